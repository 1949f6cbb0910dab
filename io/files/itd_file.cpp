#include "itd_file.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "../../envelope/whole/void_network.hpp"
#include "../pictures/site_style.hpp"

namespace vcell {

namespace {

// Weight first, coordinates times it.
template <class Point>
void write_point(std::ostream& out, const Point& p) {
    const Eigen::Index last = p.size() - 1;
    fmt::print(out, " [{}", p[last]);
    for (Eigen::Index k = 0; k < last; ++k) fmt::print(out, " {}", p[last] * p[k]);
    out << "]";
}

template <int Dim>
void write_curve(std::ostream& out, const RationalCurve<Dim>& curve) {
    fmt::print(out, "[CURVE BSPLINE {} {} P{}\n  [KV", curve.points.size(), curve.degree + 1, Dim);
    for (const double knot : curve.knots) fmt::print(out, " {}", knot);
    out << "]\n ";
    for (const auto& p : curve.points) write_point(out, p);
    out << "]";
}

// In parameters that run from 0 to 1 on the patch.
RationalCurve2 on_unit_square(RationalCurve2 curve, const RationalPatch& patch) {
    const auto to_unit = [](double x, const std::array<double, 2>& domain) {
        return (x - domain[0]) / (domain[1] - domain[0]);
    };
    for (auto& p : curve.points) {
        p[0] = to_unit(p[0], patch.domain_u);
        p[1] = to_unit(p[1], patch.domain_v);
    }
    return curve;
}

void write_surface(std::ostream& out, const RationalPatch& patch) {
    fmt::print(out, "[SURFACE BEZIER {} {} P3\n ", patch.degree_u + 1, patch.degree_v + 1);
    // u runs fastest.
    for (int j = 0; j <= patch.degree_v; ++j)
        for (int i = 0; i <= patch.degree_u; ++i) write_point(out, patch.point(i, j));
    out << "]\n";
}

}  // namespace

namespace {

// All of the cell has that colour, or without one each face that of its site.
void write_objects(std::ostream& out, const Cell& cell, std::string_view prefix,
                   std::optional<std::string_view> of_all) {
    const auto colours = object_colours(cell);
    for (std::size_t f = 0; f < cell.faces.size(); ++f) {
        const CellFace& face = cell.faces[f];
        const std::string_view colour = of_all                  ? *of_all
                                        : face.site.is_object() ? palette()[colours.at(face.site.index)]
                                                                : std::string_view("#dddddd");
        for (std::size_t p = 0; p < face.patches.size(); ++p) {
            const TrimmedPatch& patch = face.patches[p];
            fmt::print(out, "[OBJECT [RGB \"{}\"] [neighbor \"{}\"] {}FACE{}_{}\n[TRIMSRF\n",
                       fmt::join(channels(colour), ","), to_string(site_in_diagram(cell, face.site)), prefix,
                       f, p);
            write_surface(out, patch.surface);
            for (const auto& loop : patch.loops) {
                out << "[TRIMCRV\n";
                for (const TrimCurve& trim : loop) {
                    out << "[TRIMCRVSEG ";
                    write_curve(out, on_unit_square(trim.curve, patch.surface));
                    out << "]\n";
                }
                out << "]\n";
            }
            out << "]\n]\n";
        }
    }
    for (std::size_t e = 0; e < cell.edges.size(); ++e) {
        fmt::print(out, "[OBJECT {}EDGE{}\n", prefix, e);
        write_curve(out, cell.edges[e].curve);
        out << "\n]\n";
    }
    for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
        const CellVertex& vertex = cell.vertices[v];
        fmt::print(out, "[OBJECT [clearance {}] {}VERTEX{} [POINT {} {} {}]]\n", vertex.radius, prefix, v,
                   vertex.point.x(), vertex.point.y(), vertex.point.z());
    }
}

}  // namespace

void write_itd(std::ostream& out, const Cell& cell) { write_objects(out, cell, "", std::nullopt); }

void DiagramItd::add(std::uint32_t object, const Cell& cell) {
    // A plane has a cell on each side.
    const std::string prefix = fmt::format("CELL{}{}_", object, object == last_ ? "B" : "");
    write_objects(out_, cell, prefix, palette()[colours_.add(object, cell)]);
    last_ = object;
}

}  // namespace vcell
