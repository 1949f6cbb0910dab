#include "svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <unordered_map>
#include <variant>
#include <vector>

#include "../../primitives/bases/plane_base.hpp"
#include "../files/text.hpp"
#include "labels.hpp"
#include "site_style.hpp"
#include "unfold.hpp"

namespace vcell {

namespace {

class Picture {
public:
    Picture(std::ostream& out, const Cell& cell) : out_(out), cell_(cell), colours_(object_colours(cell)) {}

    /// In the chart of a plane base.
    void draw() {
        project_cylinder_faces();
        const auto [low, high] = bounds();
        has_lengths_ = true;
        frame(low, high);
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            if (!is_entered(cell_, cell_.faces[f])) face(f);
        edges_and_vertices();
        print("</g>\n");
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            if (!is_entered(cell_, cell_.faces[f])) label(f, polygons(f));
        legend(low, high);
        print("</svg>\n");
        flush();
    }

    void draw(const Unfolding& unfolding) {
        Vec2 low = Vec2::Constant(INFINITY), high = -low;
        for (const Unfolding::Panel& panel : unfolding.panels) {
            low = low.cwiseMin(panel.low);
            high = high.cwiseMax(panel.high);
        }
        frame(low, high);
        std::string path;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            path.clear();
            for (const auto& polygon : unfolding.faces[f]) append(path, polygon, "Z");
            face(f, path);
        }
        for (const Unfolding::Panel& panel : unfolding.panels)
            print("<rect class=\"panel\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n",
                  number(panel.low.x()), number(panel.low.y()), number(panel.high.x() - panel.low.x()),
                  number(panel.high.y() - panel.low.y()));
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            path.clear();
            for (const auto& line : unfolding.edges[e]) append(path, line, "");
            edge(e, path, std::ranges::any_of(cell_.edges[e].sites, is_end));
        }
        for (std::size_t v = 0; v < cell_.vertices.size(); ++v) vertex(v, unfolding.vertices[v]);
        print("</g>\n");
        for (const Unfolding::Panel& panel : unfolding.panels)
            print("<text class=\"panel\" x=\"{}\" y=\"{}\">{}</text>\n", number(panel.low.x() + size_ / 200),
                  number(-panel.low.y() - size_ / 200), panel.name);
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) label(f, unfolding.faces[f]);
        legend(low, high);
        print("</svg>\n");
        flush();
    }

private:
    using Piece = const TrimCurve*;

    static bool is_end(Site s) { return s.kind == Site::Kind::End; }

    template <class... Args>
    void print(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(buffer_), format, std::forward<Args>(args)...);
        constexpr std::size_t enough = 1 << 16;
        if (buffer_.size() > enough) flush();
    }
    void flush() {
        out_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
        buffer_.clear();
    }

    // Patches over cylinders have parameters of their own: in the chart their trims are the projections of
    // the edges' space curves, of which rational curves have exact ones.
    void project_cylinder_faces() {
        const auto is_tube = [&](Site s) {
            return s.is_object() && std::holds_alternative<Cylinder>(cell_.scene.objects[s.index]);
        };
        std::optional<BaseFrame> frame;
        for (const CellFace& face : cell_.faces) {
            if (!is_tube(face.site)) continue;
            if (!frame) frame = plane_base_problem(cell_.scene).frame;
            for (const TrimmedPatch& patch : face.patches)
                for (const auto& loop : patch.loops)
                    for (const TrimCurve& c : loop)
                        if (c.edge) projected_[&c] = projection(c, cell_.edges[*c.edge].curve, *frame);
        }
    }

    static TrimCurve projection(const TrimCurve& c, const RationalCurve3& space, const BaseFrame& frame) {
        TrimCurve result{c.edge, c.seam, c.reversed, {space.degree, space.knots, {}}};
        for (const Eigen::Vector4d& p : space.points) {
            const Vec3 canonical = frame.to_canonical(p.head<3>());
            result.curve.points.push_back({canonical.x(), canonical.y(), p.w()});
        }
        if (!c.reversed) return result;
        std::reverse(result.curve.points.begin(), result.curve.points.end());
        std::reverse(result.curve.knots.begin(), result.curve.knots.end());
        for (double& k : result.curve.knots) k = space.domain_begin() + space.domain_end() - k;
        return result;
    }

    const TrimCurve& in_chart(const TrimCurve& c) const {
        const auto projected = projected_.find(&c);
        return projected == projected_.end() ? c : projected->second;
    }

    template <class F>
    void for_each_curve(F f) const {
        for (const CellFace& face : cell_.faces)
            for (const TrimmedPatch& patch : face.patches)
                for (const auto& loop : patch.loops)
                    for (const TrimCurve& c : loop)
                        if (!is_entered(cell_, face)) f(in_chart(c));
    }

    std::array<Vec2, 2> bounds() const {
        constexpr int samples = 16;  // of a curve; the region's corners are curve ends, so they are exact
        Vec2 low = Vec2::Constant(INFINITY), high = Vec2::Constant(-INFINITY);
        for_each_curve([&](const TrimCurve& c) {
            const double begin = c.curve.domain_begin(), end = c.curve.domain_end();
            for (int i = 0; i <= samples; ++i) {
                const Vec2 p = c.curve.evaluate(begin + (end - begin) * i / samples);
                low = low.cwiseMin(p);
                high = high.cwiseMax(p);
            }
        });
        if (!(low.x() <= high.x())) low = Vec2::Zero(), high = Vec2::Ones();
        return {low, high};
    }

    // The picture's coordinates, header and style.
    void frame(const Vec2& low, const Vec2& high) {
        const Vec2 extent = high - low;
        size_ = extent.maxCoeff();
        tolerance_ = 1e-6 * size_;
        // Enough digits to place a point to a tenth of the tolerance, wherever the chart lies.
        const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
        digits_ = std::clamp(static_cast<int>(std::ceil(std::log10(largest / size_) + 7.0)), 7, 17);

        const double crowd = std::sqrt(static_cast<double>(std::max<std::size_t>(cell_.vertices.size(), 1)));
        const double stroke = size_ * std::min(1.0 / 400, 0.05 / crowd);
        dot_ = size_ * std::min(1.0 / 160, 0.12 / crowd);
        const double margin = size_ / 100;
        constexpr double width = 800;  // pixels
        pixel_ = (extent.x() + 2 * margin) / width;
        const double height =
            extent.y() + 2 * margin + (has_lengths_ || has_hatches() ? legend_height * pixel_ : 0);
        print(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{:.0f}\" height=\"{:.0f}\" "
            "viewBox=\"{} {} {} {}\">\n",
            width, std::max(1.0, height / pixel_), number(low.x() - margin), number(-high.y() - margin),
            number(extent.x() + 2 * margin), number(height));
        print("<title>Voronoi cell: minimization diagram, {} faces, {} edges, {} vertices</title>\n",
              cell_.faces.size(), cell_.edges.size(), cell_.vertices.size());
        print(
            "<style>\n.face{{fill:#dddddd;stroke:none}}\n.box{{fill:url(#hatch)}}\n"
            ".edge{{fill:none;stroke:#222222;stroke-width:{0};stroke-linecap:round;stroke-linejoin:round}}\n"
            ".rim{{stroke-width:{1}}}\n.vertex{{fill:#ffffff;stroke:#222222;stroke-width:{2}}}\n",
            number(stroke), number(2 * stroke), number(0.6 * stroke));
        print(
            "rect.panel{{fill:none;stroke:#888888;stroke-width:{0};stroke-dasharray:{1}}}\n"
            "text.panel{{fill:#444444;font-family:sans-serif;font-size:{2}px}}\n",
            number(0.6 * stroke), number(2 * stroke), number(size_ / 50));
        print(
            ".words{{fill:#222222;font-family:sans-serif;font-size:{}px;pointer-events:none}}\n"
            "text.label{{text-anchor:middle}}\n.bar{{fill:none;stroke:#222222;stroke-width:1.5}}\n",
            letter);
        for (std::size_t c = 0; c < palette().size(); ++c) print(".c{}{{fill:{}}}\n", c, palette()[c]);
        print(
            "</style>\n<defs><pattern id=\"hatch\" patternUnits=\"userSpaceOnUse\" width=\"{0}\" "
            "height=\"{0}\" "
            "patternTransform=\"rotate(45)\"><rect width=\"{0}\" height=\"{0}\" fill=\"#eeeeee\"/>"
            "<rect width=\"{1}\" height=\"{0}\" fill=\"#cccccc\"/></pattern></defs>\n",
            number(size_ / 80), number(size_ / 320));
        print("<g transform=\"scale(1,-1)\">\n");
    }

    // Texts are in pixels: letters of a tiny picture's units have no shapes in some viewers.
    std::string in_pixels(const Vec2& at) const {
        return fmt::format("transform=\"translate({} {}) scale({})\"", number(at.x()), number(0.0 - at.y()),
                           number(pixel_));
    }

    /// A face as polygons, a few sides for each curve.
    std::vector<std::vector<Vec2>> polygons(std::size_t index) const {
        constexpr int samples = 16;
        std::vector<std::vector<Vec2>> result;
        for (const TrimmedPatch& patch : cell_.faces[index].patches)
            for (const auto& loop : patch.loops) {
                std::vector<Vec2>& polygon = result.emplace_back();
                for (const TrimCurve& c : loop) {
                    const RationalCurve2& curve = in_chart(c).curve;
                    const double begin = curve.domain_begin(), end = curve.domain_end();
                    for (int i = 0; i < samples; ++i)
                        polygon.push_back(curve.evaluate(begin + (end - begin) * i / samples));
                }
            }
        return result;
    }

    /// The object's name, or its number, where there is room in its face.
    void label(std::size_t index, std::span<const std::vector<Vec2>> polygons) {
        const Site site = cell_.faces[index].site;
        if (!site.is_object()) return;
        const bool has_name = site.index < cell_.scene.names.size() && !cell_.scene.names[site.index].empty();
        const std::string text = has_name ? cell_.scene.names[site.index] : std::to_string(site.index);
        constexpr double wide = 0.65;  // of a letter's height
        const auto place = place_of_text(polygons, wide * letter * pixel_ * static_cast<double>(text.size()),
                                         letter * pixel_);
        if (place)
            print("<text class=\"words label\" {} y=\"{:.3g}\">{}</text>\n", in_pixels(*place), 0.35 * letter,
                  xml_escaped(text));
    }

    bool has_hatches() const {
        return std::ranges::any_of(
            cell_.faces, [&](const CellFace& f) { return !f.site.is_object() && !is_entered(cell_, f); });
    }

    /// Under the picture: how long a length is, and what is hatched.
    void legend(const Vec2& low, const Vec2& high) {
        const double line = low.y() - size_ / 100 - (legend_height - 8) * pixel_;
        double x = low.x();
        if (has_lengths_) {
            const double length = round_length((high.x() - low.x()) / 4), bar = length / pixel_;
            print("<g {}><path class=\"bar\" d=\"M0,-6V0H{:.2f}V-6\"/>", in_pixels({x, line}), bar);
            print("<text class=\"words\" x=\"{:.2f}\">{:.6g} {}</text></g>\n", bar + 6, length,
                  xml_escaped(cell_.scene.units));
            x += length + 120 * pixel_;
        }
        if (!has_hatches()) return;
        print("<rect class=\"box\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", number(x),
              number(-line - 11 * pixel_), number(22 * pixel_), number(12 * pixel_));
        print("<text class=\"words\" {}>sides of the box</text>\n", in_pixels({x + 28 * pixel_, line}));
    }

    void face(std::size_t index) {
        std::string path;
        for (const TrimmedPatch& patch : cell_.faces[index].patches)
            for (const auto& loop : patch.loops) {
                move_to(path, in_chart(loop.front()).curve);
                for (const TrimCurve& c : loop) append(path, in_chart(c).curve);
                path += 'Z';
            }
        face(index, path);
    }

    void face(std::size_t index, const std::string& path) {
        const CellFace& f = cell_.faces[index];
        std::string style = "box";
        if (f.site.is_object()) style = fmt::format("c{}", colours_.at(f.site.index));
        std::string who = site_title(cell_.scene, f.site);
        for (const Site s : f.extra_sites) who += fmt::format(" = {}", site_title(cell_.scene, s));
        print(
            "<path class=\"face {}\" fill-rule=\"evenodd\" data-face=\"{}\" data-object=\"{}\" d=\"{}\">"
            "<title>{}: {}, area {:.6g}</title></path>\n",
            style, index, to_string(f.site), path, xml_escaped(who), xml_escaped(f.bisector), f.area);
    }

    void edges_and_vertices() {
        std::vector<std::pair<Piece, int>> first_use(cell_.edges.size());  // and how often the edge is used
        for_each_curve([&](const TrimCurve& c) {
            if (!c.edge) return;
            auto& [piece, uses] = first_use[*c.edge];
            if (uses++ == 0) piece = &c;
        });
        std::map<std::uint32_t, Vec2> place;
        for (std::size_t e = 0; e < first_use.size(); ++e) {
            const auto [piece, uses] = first_use[e];
            if (uses == 0) continue;
            std::string path;
            move_to(path, piece->curve);
            append(path, piece->curve);
            edge(e, path, uses == 1);
            const CellEdge& from = cell_.edges[e];
            if (from.vertices.size() != 2) continue;
            place[from.vertices[piece->reversed ? 1 : 0]] = end_point(piece->curve.points.front());
            place[from.vertices[piece->reversed ? 0 : 1]] = end_point(piece->curve.points.back());
        }
        for (const auto& [v, point] : place) vertex(v, point);
    }

    void edge(std::size_t index, const std::string& path, bool is_rim) {
        const CellEdge& e = cell_.edges[index];
        print("<path class=\"edge{} {}\" data-edge=\"{}\" d=\"{}\"><title>{} | {}: {}</title></path>\n",
              is_rim ? " rim" : "", to_string(e.kind), index, path,
              xml_escaped(site_title(cell_.scene, e.sites[0])),
              xml_escaped(site_title(cell_.scene, e.sites[1])), to_string(e.kind));
    }

    void vertex(std::size_t index, const Vec2& point) {
        const CellVertex& v = cell_.vertices[index];
        std::string who;
        for (const Site s : v.sites) who += fmt::format(", {}", site_title(cell_.scene, s));
        print(
            "<circle class=\"vertex\" data-vertex=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\">"
            "<title>clearance {:.9g}{}</title></circle>\n",
            index, number(point.x()), number(point.y()), number(dot_), v.radius, xml_escaped(who));
    }

    static Vec2 end_point(const Eigen::Vector3d& control_point) { return control_point.head<2>(); }

    std::string number(double x) const { return fmt::format("{:.{}g}", x, digits_); }
    std::string pair(const Vec2& p) const {
        return fmt::format("{:.{}g},{:.{}g}", p.x(), digits_, p.y(), digits_);
    }
    void move_to(std::string& path, const RationalCurve2& c) const {
        path += fmt::format("M{}", pair(end_point(c.points.front())));
    }

    void append(std::string& path, const Unfolding::Polyline& line, const char* close) const {
        for (std::size_t i = 0; i < line.size(); ++i)
            path += fmt::format("{}{}", i == 0 ? 'M' : 'L', pair(line[i]));
        path += close;
    }

    // Appends the curve to a path that has reached its start.
    void append(std::string& path, const RationalCurve2& c) const {
        const auto degree = static_cast<std::size_t>(c.degree);
        bool bezier_pieces = true;  // every inner knot is there `degree` times
        for (std::size_t i = degree + 1; i + degree < c.points.size() + 1; i += degree)
            bezier_pieces = bezier_pieces && c.knots[i] == c.knots[i + degree - 1];
        bezier_pieces = bezier_pieces && (c.points.size() - 1) % degree == 0;
        for (std::size_t i = degree; i < c.points.size(); ++i) {
            if (c.knots[i] == c.knots[i + 1]) continue;
            // Knot span i; as a Bezier piece its control points are i - degree ... i.
            const bool exact = bezier_pieces &&
                               append_exact(path, {c.points.begin() + static_cast<std::ptrdiff_t>(i - degree),
                                                   c.points.begin() + static_cast<std::ptrdiff_t>(i) + 1});
            if (!exact) append_cubics(path, c, c.knots[i], c.knots[i + 1], 0);
        }
    }

    // Lines, parabolas, circular arcs and polynomial cubics have words of their own.
    bool append_exact(std::string& path, const std::vector<Eigen::Vector3d>& p) const {
        const std::size_t degree = p.size() - 1;
        if (degree == 1) {
            path += fmt::format("L{}", pair(end_point(p[1])));
            return true;
        }
        if (degree != 2) return false;
        const Vec2 a = end_point(p[0]), b = end_point(p[1]), c = end_point(p[2]);
        const Vec2 chord = c - a, leg = b - a;
        const double shoulder = p[1].z() / std::sqrt(p[0].z() * p[2].z());
        const double reach = (b - 0.5 * (a + c)).norm();
        if (reach * std::abs(1 - shoulder) < tolerance_) {
            path += fmt::format("Q{} {}", pair(b), pair(c));
            return true;
        }
        // An arc of half angle h: an isosceles control triangle with angle h at the chord and shoulder
        // weight cos h; it spans less than a half turn.
        const double cosine = chord.dot(leg) / (chord.norm() * leg.norm());
        const double sine = (leg.x() * chord.y() - leg.y() * chord.x()) / (chord.norm() * leg.norm());
        const bool circular = std::abs(leg.norm() - (c - b).norm()) < tolerance_ &&
                              std::abs(shoulder - cosine) * reach < tolerance_;
        if (!circular) return false;
        const std::string radius = number(0.5 * chord.norm() / std::abs(sine));
        path += fmt::format("A{} {} 0 0 {} {}", radius, radius, sine > 0 ? 1 : 0, pair(c));
        return true;
    }

    // Cubic Hermite pieces over [from, to], halved until they follow the curve to the tolerance.
    void append_cubics(std::string& path, const RationalCurve2& c, double from, double to, int depth) const {
        constexpr int deepest = 12;
        const auto [p0, d0] = c.evaluate_with_derivative(from);
        // Just before `to`: at a knot the derivative belongs to the next span.
        const auto [p3, d3] = c.evaluate_with_derivative(std::nextafter(to, from));
        const double h = to - from;
        const Vec2 p1 = p0 + d0 * (h / 3), p2 = p3 - d3 * (h / 3);
        double deviation = 0;
        for (const double s : {0.25, 0.5, 0.75}) {
            const double r = 1 - s;
            const Vec2 q = r * r * r * p0 + 3 * r * r * s * p1 + 3 * r * s * s * p2 + s * s * s * p3;
            deviation = std::max(deviation, (q - c.evaluate(from + s * h)).norm());
        }
        if (deviation > tolerance_ && depth < deepest) {
            append_cubics(path, c, from, from + 0.5 * h, depth + 1);
            append_cubics(path, c, from + 0.5 * h, to, depth + 1);
            return;
        }
        path += fmt::format("C{} {} {}", pair(p1), pair(p2), pair(p3));
    }

    std::ostream& out_;
    const Cell& cell_;
    std::unordered_map<std::uint32_t, std::size_t> colours_;
    std::unordered_map<const TrimCurve*, TrimCurve> projected_;  // of the faces of cylinders
    std::string buffer_;
    static constexpr double letter = 12, legend_height = 26;  // pixels
    bool has_lengths_ = false;                                // the chart's coordinates are lengths
    double pixel_ = 1;      // of the picture as wide as it says, in the chart's units
    double size_ = 1;       // of the chart, its units
    double tolerance_ = 0;  // of fitted curves, the same
    double dot_ = 0;        // radius of a vertex
    int digits_ = 7;
};

}  // namespace

void write_svg(std::ostream& out, const Cell& cell) {
    Picture picture(out, cell);
    if (std::holds_alternative<Plane>(cell.scene.base))
        picture.draw();
    else
        picture.draw(unfold(cell));
}

}  // namespace vcell
