#include "diagram_pictures.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <utility>

#include "../../envelope/whole/own_periods.hpp"
#include "../files/text.hpp"
#include "obj.hpp"
#include "site_style.hpp"

namespace vcell {

std::size_t CellColours::add(std::uint32_t object, const Cell& cell) {
    std::vector<std::size_t> beside(palette().size(), 0);
    if (!cell.scene.numbers.empty())
        for (const std::uint32_t neighbor : cell.neighbors)
            if (const auto c = of_.find(neighbor); c != of_.end()) ++beside[c->second];
    // Colours take turns where several would do.
    std::size_t best = object % beside.size();
    for (std::size_t k = 0; k < beside.size(); ++k) {
        const std::size_t c = (object + k) % beside.size();
        if (beside[c] < beside[best]) best = c;
    }
    return of_[object] = best;
}

// ---- OBJ --------------------------------------------------------------------------------------------

DiagramObj::DiagramObj(std::ostream& out, const std::string& material_file)
    : out_(out), has_materials_(!material_file.empty()) {
    out_ << "# Voronoi diagram\n";
    if (has_materials_) out_ << "mtllib " << material_file << "\n";
}

void DiagramObj::add(std::uint32_t object, const Cell& cell, const CellMesh& mesh) {
    // Blanks would end the name.
    std::string name = cell.scene.base_name.empty() ? "" : "_" + cell.scene.base_name;
    std::ranges::replace_if(
        name, [](unsigned char c) { return c <= ' '; }, '_');
    fmt::print(out_, "o cell_{}{}\n", object, name);
    const std::string material = has_materials_ ? fmt::format("c{}", colours_.add(object, cell)) : "";
    write_obj_mesh(out_, mesh, {points_, normals_, material});
    points_ += mesh.points.size();
    normals_ += mesh.normals.size();
}

void DiagramObj::write_mtl(std::ostream& out) {
    for (std::size_t c = 0; c < palette().size(); ++c)
        write_material(out, fmt::format("c{}", c), palette()[c]);
}

// ---- SVG --------------------------------------------------------------------------------------------

void DiagramCut::add(std::uint32_t object, const Cell& cell, const CellMesh& mesh) {
    Section section{object, colours_.add(object, cell), {}};
    // A tube that closes on itself has one period of its cell here, which meets the plane wherever its images
    // do.
    const Vec3 period = period_of(object);
    double low = at_, high = at_;
    for (const Vec3& p : mesh.points) {
        low = std::min(low, p[axis_]);
        high = std::max(high, p[axis_]);
    }
    const double step = std::abs(period[axis_]);
    const int before = step > 0 ? static_cast<int>((at_ - low) / step) : 0,
              after = step > 0 ? static_cast<int>((high - at_) / step) : 0;
    for (int k = -before; k <= after; ++k) {
        const Vec3 by = (period[axis_] < 0 ? -k : k) * period;
        add_section(mesh, at_ + by[axis_], -by, section);
    }
    if (!section.polygons.empty()) sections_.push_back(std::move(section));
}

Vec3 DiagramCut::period_of(std::uint32_t object) const {
    if (!std::holds_alternative<Cylinder>(scene_.objects[object])) return Vec3::Zero();
    const whole::Lattice lattice(scene_);
    const auto periods = whole::own_periods(lattice, scene_.objects[object]);
    return periods && !periods->empty() ? lattice.shift(periods->front()) : Vec3(Vec3::Zero());
}

void DiagramCut::add_section(const CellMesh& mesh, double at, const Vec3& by, Section& section) const {
    const auto is_above = [&](std::uint32_t p) { return mesh.points[p][axis_] >= at; };
    // On its way around a triangle the boundary comes down through the plane on one side and up on another
    // one: which is where it comes down in the triangle next to it.
    using Side = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<std::pair<Side, Side>> steps;
    for (const Triangle& t : mesh.triangles) {
        std::array<Side, 2> down_up;
        int crossings = 0;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (is_above(a) == is_above(b)) continue;
            down_up[is_above(a) ? 0 : 1] = std::minmax(a, b);
            ++crossings;
        }
        if (crossings == 2) steps.emplace_back(down_up[0], down_up[1]);
    }
    std::ranges::sort(steps);
    std::vector<bool> is_used(steps.size(), false);
    for (std::size_t first = 0; first < steps.size(); ++first) {
        Polygon polygon;
        for (std::size_t i = first; !is_used[i];) {
            is_used[i] = true;
            const auto [a, b] = steps[i].first;
            const Vec3 &p = mesh.points[a], &q = mesh.points[b];
            const double part = (at - p[axis_]) / (q[axis_] - p[axis_]);
            polygon.push_back(in_picture(p + part * (q - p) + by));
            const auto next =
                std::ranges::lower_bound(steps, steps[i].second, {}, &std::pair<Side, Side>::first);
            if (next == steps.end() || next->first != steps[i].second) break;
            i = static_cast<std::size_t>(next - steps.begin());
        }
        if (polygon.size() > 2) section.polygons.push_back(std::move(polygon));
    }
}

// Twice the area of the largest polygon, and its centre.
static std::pair<double, Vec2> largest(const std::vector<std::vector<Vec2>>& polygons) {
    std::pair<double, Vec2> best{0, Vec2::Zero()};
    for (const auto& polygon : polygons) {
        double twice = 0;
        Vec2 sum = Vec2::Zero();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec2 p = polygon[i] - polygon[0], q = polygon[(i + 1) % polygon.size()] - polygon[0];
            const double cross = p.x() * q.y() - p.y() * q.x();
            twice += cross;
            sum += cross * (p + q);
        }
        if (std::abs(twice) > best.first) best = {std::abs(twice), polygon[0] + sum / (3 * twice)};
    }
    return best;
}

void DiagramCut::write(std::ostream& out) const {
    Vec2 low = in_picture(scene_.box.min), high = in_picture(scene_.box.max);
    for (const Section& s : sections_)
        for (const Polygon& polygon : s.polygons)
            for (const Vec2& p : polygon) {
                low = low.cwiseMin(p);
                high = high.cwiseMax(p);
            }
    // Pixels: letters of a tiny picture's units have no shapes in some viewers.
    constexpr double width = 800, margin = 8, letter = 11;
    const double scale = (width - 2 * margin) / (high - low).maxCoeff();
    const auto pixels = [&](const Vec2& p) {
        return Vec2(margin + scale * (p.x() - low.x()), margin + scale * (high.y() - p.y()));
    };
    const Vec2 size = scale * (high - low) + Vec2::Constant(2 * margin);
    const auto title = [&](std::uint32_t object) {
        const bool has_name = object < scene_.names.size() && !scene_.names[object].empty();
        return has_name ? xml_escaped(scene_.names[object]) : std::to_string(object);
    };
    fmt::print(out,
               "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{0:.0f}\" "
               "height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\">\n<title>Voronoi diagram at {2} = "
               "{3}</title>\n",
               size.x(), size.y(), "xyz"[axis_], at_);
    fmt::print(out,
               "<style>\n.cell{{stroke:#222222;stroke-width:1;stroke-linejoin:round}}\n"
               ".object{{fill:#000000;fill-opacity:0.12;stroke:#444444;stroke-width:0.5}}\n"
               "text{{fill:#222222;font-family:sans-serif;font-size:{}px;text-anchor:middle}}\n",
               letter);
    for (std::size_t c = 0; c < palette().size(); ++c) fmt::print(out, ".c{}{{fill:{}}}\n", c, palette()[c]);
    out << "</style>\n";
    for (const Section& s : sections_) {
        fmt::print(out, "<path class=\"cell c{}\" fill-rule=\"evenodd\" data-object=\"{}\" d=\"", s.colour,
                   s.object);
        for (const Polygon& polygon : s.polygons)
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Vec2 p = pixels(polygon[i]);
                fmt::print(out, "{}{:.7g},{:.7g}{}", i == 0 ? 'M' : 'L', p.x(), p.y(),
                           i + 1 == polygon.size() ? "Z" : "");
            }
        fmt::print(out, "\"><title>{}</title></path>\n", title(s.object));
    }
    for (const Section& s : sections_)
        if (const auto* ball = std::get_if<Sphere>(&scene_.objects[s.object])) {
            const double off = ball->center[axis_] - at_, square = ball->radius * ball->radius - off * off;
            if (!(square > 0)) continue;
            const Vec2 c = pixels(in_picture(ball->center));
            fmt::print(out, "<circle class=\"object\" cx=\"{:.7g}\" cy=\"{:.7g}\" r=\"{:.7g}\"/>\n", c.x(),
                       c.y(), scale * std::sqrt(square));
        }
    for (const Section& s : sections_) {
        const auto [twice, center] = largest(s.polygons);
        const std::string text = title(s.object);
        const double room = 0.5 * scale * scale * twice;
        if (!(room > 1.5 * letter * letter * static_cast<double>(text.size()))) continue;
        const Vec2 place = pixels(center);
        fmt::print(out, "<text x=\"{:.7g}\" y=\"{:.7g}\">{}</text>\n", place.x(), place.y() + 0.35 * letter,
                   text);
    }
    out << "</svg>\n";
}

}  // namespace vcell
