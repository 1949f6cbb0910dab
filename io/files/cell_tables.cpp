#include "cell_tables.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "../../envelope/measures/clearance_places.hpp"
#include "../check/space.hpp"
#include "../solids/moments.hpp"

namespace vcell {

namespace {

std::string name_of(const Cell& cell, Site site) {
    const std::vector<std::string>& names = cell.scene.names;
    if (!site.is_object() || site.index >= names.size() || names[site.index].empty()) return "-";
    return names[site.index];
}

template <class Sites, class Text>
std::string joined(const Sites& sites, Text text) {
    std::string all;
    for (const Site site : sites) all += (all.empty() ? "" : " ") + text(site);
    return all;
}

std::vector<int> faces_at_edges(const Cell& cell) {
    std::vector<int> count(cell.edges.size(), 0);
    for (const CellFace& face : cell.faces)
        for (const TrimCurve& trim : face.trims())
            if (trim.edge) ++count[*trim.edge];
    return count;
}

struct Angle {
    double degrees, error;
};

// Between the faces that point into the cell along a and b, by the lengths of a + b and a - b: no cosine
// loses digits where they are all but one plane.
std::optional<Angle> inner_angle(const check::Vector<Interval>& a, const check::Vector<Interval>& b) {
    using check::operator+, check::operator-;
    using std::numbers::pi;
    constexpr double roundings = 8 * std::numeric_limits<double>::epsilon();
    const Interval sum = sqrt(check::square(a + b)), difference = sqrt(check::square(a - b));
    const double least = 360 / pi * std::atan2(sum.lower(), difference.upper()) * (1 - roundings),
                 most = 360 / pi * std::atan2(sum.upper(), difference.lower()) * (1 + roundings);
    const Angle angle{0.5 * (least + most), 0.5 * (most - least) * (1 + roundings) + 180 * roundings};
    if (!(angle.error < 90)) return std::nullopt;
    return angle;
}

std::optional<Angle> dihedral_angle(const check::Space<Interval>& space, const CellEdge& edge) {
    const RationalCurve3& curve = edge.curve;
    const auto place =
        check::box_about(curve.evaluate(0.5 * (curve.domain_begin() + curve.domain_end())), edge.error);
    const auto inwards = [&](Site site) {
        const check::Vector<Interval> g = space.gradient({site}, place);
        return check::direction(g, sqrt(check::square(g)));
    };
    return inner_angle(inwards(edge.sites[0]), inwards(edge.sites[1]));
}

}  // namespace

void write_faces(std::ostream& out, const Cell& cell) {
    out << "face\tsite\tname\tbisector\tarea\tarea_error\testimated\n";
    for (std::size_t i = 0; i < cell.faces.size(); ++i) {
        const CellFace& f = cell.faces[i];
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{:d}\n", i, to_string(f.site), name_of(cell, f.site),
                   f.bisector, f.area, f.area_error, f.is_estimated);
    }
}

void write_edges(std::ostream& out, const Cell& cell) {
    out << "edge\tsite1\tsite2\tname1\tname2\tkind\tlength\tlength_error\testimated\tdihedral\tdihedral_error\n";
    const std::vector<int> faces = faces_at_edges(cell);
    const check::Space<Interval> space(cell.scene);
    for (std::size_t i = 0; i < cell.edges.size(); ++i) {
        const CellEdge& e = cell.edges[i];
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{:d}", i, to_string(e.sites[0]),
                   to_string(e.sites[1]), name_of(cell, e.sites[0]), name_of(cell, e.sites[1]),
                   to_string(e.kind), e.length, e.length_error, e.is_estimated);
        const auto angle = faces[i] == 2 ? dihedral_angle(space, e) : std::nullopt;
        if (angle)
            fmt::print(out, "\t{}\t{}\n", angle->degrees, angle->error);
        else
            out << "\t-\t-\n";
    }
}

void write_vertices(std::ostream& out, const Cell& cell) {
    out << "vertex\tx\ty\tz\tclearance\terror\ttouching\tsites\tnames\n";
    for (std::size_t i = 0; i < cell.vertices.size(); ++i) {
        const CellVertex& v = cell.vertices[i];
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{:d}\t{}\t{}\n", i, v.point.x(), v.point.y(), v.point.z(),
                   v.radius, v.error, v.is_touching, joined(v.sites, [](Site s) { return to_string(s); }),
                   joined(v.sites, [&](Site s) { return name_of(cell, s); }));
    }
}

void write_clearances(std::ostream& out, const Cell& cell) {
    out << "extreme\tclearance\tclearance_error\tx\ty\tz\terror\tvertex\tedge\tface\tsites\tnames\n";
    const auto number = [](const std::optional<std::uint32_t>& n) { return n ? std::to_string(*n) : "-"; };
    const ClearancePlaces places = clearance_places(cell);
    for (const auto& [extreme, place] :
         {std::pair("least", &places.least), std::pair("greatest", &places.greatest)}) {
        if (!*place) {
            fmt::print(out, "{}\t-\t-\t-\t-\t-\t-\t-\t-\t-\t-\t-\n", extreme);
            continue;
        }
        const ClearancePlace& p = **place;
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\n", extreme, p.clearance,
                   p.clearance_error, p.point.x(), p.point.y(), p.point.z(), p.error, number(p.vertex),
                   number(p.edge), number(p.face), joined(p.sites, [](Site s) { return to_string(s); }),
                   joined(p.sites, [&](Site s) { return name_of(cell, s); }));
    }
}

void write_moment_line(std::ostream& out, const Moments& m) {
    const Vec3& c = m.centroid;
    const Eigen::Matrix3d& s = m.second;
    fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\n", c.x(), c.y(), c.z(), m.centroid_error,
               s(0, 0), s(1, 1), s(2, 2), s(1, 2), s(2, 0), s(0, 1), m.second_error);
}

void write_moments(std::ostream& out, const Cell& cell) {
    out << moment_columns << '\n';
    write_moment_line(out, moments_of(cell));
}

}  // namespace vcell
