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
#include "chart_loops.hpp"
#include "contours.hpp"
#include "labels.hpp"
#include "site_style.hpp"
#include "svg_paths.hpp"
#include "unfold.hpp"

namespace vcell {

namespace {

class Picture {
public:
    Picture(std::ostream& out, const Cell& cell, std::size_t most_levels)
        : out_(out),
          cell_(cell),
          colours_(object_colours(cell)),
          levels_(round_levels(cell, most_levels)),
          contours_(contours(cell, levels_)) {}

    /// In the chart of a plane base.
    void draw() {
        loops_ = chart_loops(cell_);
        project_contours();
        const auto [low, high] = bounds();
        has_lengths_ = true;
        frame(low, high);
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            if (!is_entered(cell_, cell_.faces[f])) face(f);
        level_curves();
        edges_and_vertices();
        print("</g>\n");
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            if (!is_entered(cell_, cell_.faces[f])) label(f, polygons(f));
        label_levels();
        legend(low, high);
        print("</svg>\n");
        flush();
    }

    /// Around a ball or a tube.
    void draw_unfolded() {
        std::vector<std::vector<Vec3>> lines;
        for (const Contour& contour : contours_) lines.push_back(contour.points);
        const Unfolding unfolding = unfold(cell_, lines);
        for (std::size_t k = 0; k < contours_.size(); ++k)
            for (const auto& line : unfolding.lines[k]) level_lines_.push_back({contours_[k].level, line});
        Vec2 low = Vec2::Constant(INFINITY), high = -low;
        for (const Unfolding::Panel& panel : unfolding.panels) {
            low = low.cwiseMin(panel.low);
            high = high.cwiseMax(panel.high);
        }
        frame(low, high);
        std::string path;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            path.clear();
            for (const auto& polygon : unfolding.faces[f]) paths_.append(path, polygon, "Z");
            face(f, path);
        }
        level_curves();
        for (const Unfolding::Panel& panel : unfolding.panels)
            print("<rect class=\"panel\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n",
                  paths_.number(panel.low.x()), paths_.number(panel.low.y()),
                  paths_.number(panel.high.x() - panel.low.x()),
                  paths_.number(panel.high.y() - panel.low.y()));
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            path.clear();
            for (const auto& line : unfolding.edges[e]) paths_.append(path, line, "");
            edge(e, path, std::ranges::any_of(cell_.edges[e].sites, is_end));
        }
        for (std::size_t v = 0; v < cell_.vertices.size(); ++v) vertex(v, unfolding.vertices[v]);
        print("</g>\n");
        for (const Unfolding::Panel& panel : unfolding.panels)
            print("<text class=\"words panel\" {}>{}</text>\n",
                  in_pixels(panel.low + Vec2::Constant(size_ / 200)), panel.name);
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) label(f, unfolding.faces[f]);
        label_levels();
        legend(low, high);
        print("</svg>\n");
        flush();
    }

private:
    using Piece = const TrimCurve*;
    struct LevelLine {
        std::size_t level;
        std::vector<Vec2> points;
    };

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

    void project_contours() {
        if (contours_.empty()) return;
        const BaseFrame frame = plane_base_problem(cell_.scene).frame;
        for (const Contour& contour : contours_) {
            LevelLine& line = level_lines_.emplace_back(LevelLine{contour.level, {}});
            for (const Vec3& p : contour.points) line.points.push_back(frame.to_canonical(p).head<2>());
        }
    }

    void level_curves() {
        for (std::size_t level = 0; level < levels_.size(); ++level) {
            std::string path;
            for (const LevelLine& line : level_lines_)
                if (line.level == level) paths_.append_smooth(path, line.points);
            print(
                "<path class=\"contour\" data-clearance=\"{0:.6g}\" d=\"{1}\"><title>clearance {0:.6g}</title></path>\n",
                levels_[level], path);
        }
    }

    /// Beside its middle, along it, where no other words are.
    void label_levels() {
        for (const LevelLine& line : level_lines_) {
            const std::string text = fmt::format("{:.6g}", levels_[line.level]);
            const Vec2 room = small_letter * pixel_ * Vec2(wide * static_cast<double>(text.size()), 1);
            const auto place = place_on_line(line.points, room.x());
            if (!place || !words_.take(place->at, room)) continue;
            print("<text class=\"words label level\" {} y=\"{:.3g}\">{}</text>\n",
                  in_pixels(place->at, -place->degrees), 0.35 * small_letter, text);
        }
    }

    template <class F>
    void for_each_curve(F f) const {
        for (const std::vector<ChartLoop>& loops : loops_.of_faces)
            for (const ChartLoop& loop : loops)
                for (const TrimCurve* c : loop) f(*c);
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
        paths_.tolerance = 1e-6 * size_;
        // Enough digits to place a point to a tenth of the tolerance, wherever the chart lies.
        const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
        paths_.digits = std::clamp(static_cast<int>(std::ceil(std::log10(largest / size_) + 7.0)), 7, 17);

        const double crowd = std::sqrt(static_cast<double>(std::max<std::size_t>(cell_.vertices.size(), 1)));
        const double stroke = size_ * std::min(1.0 / 400, 0.05 / crowd);
        dot_ = size_ * std::min(1.0 / 160, 0.12 / crowd);
        const double margin = size_ / 100;
        constexpr double width = 800;  // pixels
        pixel_ = (extent.x() + 2 * margin) / width;
        const double height =
            extent.y() + 2 * margin +
            (has_lengths_ || !hatched().empty() || !levels_.empty() ? legend_height * pixel_ : 0);
        print(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" width=\"{:.0f}\" height=\"{:.0f}\" "
            "viewBox=\"{} {} {} {}\">\n",
            width, std::max(1.0, height / pixel_), paths_.number(low.x() - margin),
            paths_.number(-high.y() - margin), paths_.number(extent.x() + 2 * margin), paths_.number(height));
        print("<title>Voronoi cell: minimization diagram, {} faces, {} edges, {} vertices</title>\n",
              cell_.faces.size(), cell_.edges.size(), cell_.vertices.size());
        print(
            "<style>\n.face{{fill:#dddddd;stroke:none}}\n.box{{fill:url(#hatch)}}\n"
            ".edge{{fill:none;stroke:#222222;stroke-width:{0};stroke-linecap:round;stroke-linejoin:round}}\n"
            ".rim{{stroke-width:{1}}}\n.vertex{{fill:#ffffff;stroke:#222222;stroke-width:{2}}}\n",
            paths_.number(stroke), paths_.number(2 * stroke), paths_.number(0.6 * stroke));
        print(
            "rect.panel{{fill:none;stroke:#888888;stroke-width:{0};stroke-dasharray:{1}}}\n"
            "text.panel{{fill:#444444}}\n",
            paths_.number(0.6 * stroke), paths_.number(2 * stroke));
        print(
            ".words{{fill:#222222;font-family:sans-serif;font-size:{}px;pointer-events:none}}\n"
            "text.label{{text-anchor:middle}}\n.bar{{fill:none;stroke:#222222;stroke-width:1.5}}\n",
            letter);
        if (!levels_.empty())
            print(
                ".contour{{fill:none;stroke:#000000;stroke-opacity:0.55;stroke-width:{}}}\ntext.level{{font-size:{}px;"
                "paint-order:stroke;stroke:#ffffff;stroke-opacity:0.7;stroke-width:2px}}\n",
                paths_.number(0.7 * stroke), small_letter);
        for (std::size_t c = 0; c < palette().size(); ++c) print(".c{}{{fill:{}}}\n", c, palette()[c]);
        print(
            "</style>\n<defs><pattern id=\"hatch\" patternUnits=\"userSpaceOnUse\" width=\"{0}\" "
            "height=\"{0}\" "
            "patternTransform=\"rotate(45)\"><rect width=\"{0}\" height=\"{0}\" fill=\"#eeeeee\"/>"
            "<rect width=\"{1}\" height=\"{0}\" fill=\"#cccccc\"/></pattern></defs>\n",
            paths_.number(size_ / 80), paths_.number(size_ / 320));
        print("<g transform=\"scale(1,-1)\">\n");
    }

    // Texts are in pixels: letters of a tiny picture's units have no shapes in some viewers.
    std::string in_pixels(const Vec2& at, double degrees = 0) const {
        const std::string turn = degrees != 0 ? fmt::format(" rotate({:.4g})", degrees) : "";
        return fmt::format("transform=\"translate({} {}) scale({}){}\"", paths_.number(at.x()),
                           paths_.number(0.0 - at.y()), paths_.number(pixel_), turn);
    }

    /// A face as polygons, a few sides for each curve.
    std::vector<std::vector<Vec2>> polygons(std::size_t index) const {
        constexpr int samples = 16;
        std::vector<std::vector<Vec2>> result;
        for (const ChartLoop& loop : loops_.of_faces[index]) {
            std::vector<Vec2>& polygon = result.emplace_back();
            for (const TrimCurve* c : loop) {
                const double begin = c->curve.domain_begin(), end = c->curve.domain_end();
                for (int i = 0; i < samples; ++i)
                    polygon.push_back(c->curve.evaluate(begin + (end - begin) * i / samples));
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
        const Vec2 room = letter * pixel_ * Vec2(wide * static_cast<double>(text.size()), 1);
        const auto place = place_of_text(polygons, room.x(), room.y());
        if (!place) return;
        words_.take(*place, room);
        print("<text class=\"words label\" {} y=\"{:.3g}\">{}</text>\n", in_pixels(*place), 0.35 * letter,
              xml_escaped(text));
    }

    /// What no object owns.
    std::string hatched() const {
        bool has_side = false, has_cap = false;
        for (const CellFace& f : cell_.faces) {
            const bool is_cap = f.site.kind == Site::Kind::Cap;
            has_cap = has_cap || is_cap;
            has_side = has_side || !(is_cap || f.site.is_object() || is_entered(cell_, f));
        }
        return has_side && has_cap ? "sides of the box, the cap"
               : has_side          ? "sides of the box"
               : has_cap           ? "the cap"
                                   : "";
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
        if (levels_.size() > 1) {
            print("<g {}><path class=\"bar level\" d=\"M0,-5H22\"/><text class=\"words\" x=\"28\">",
                  in_pixels({x, line}));
            print("clearance, every {:.6g} {}</text></g>\n", levels_[1] - levels_[0],
                  xml_escaped(cell_.scene.units));
            x += 220 * pixel_;
        }
        const std::string words = hatched();
        if (words.empty()) return;
        print("<rect class=\"box\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", paths_.number(x),
              paths_.number(-line - 11 * pixel_), paths_.number(22 * pixel_), paths_.number(12 * pixel_));
        print("<text class=\"words\" {}>{}</text>\n", in_pixels({x + 28 * pixel_, line}), words);
    }

    void face(std::size_t index) {
        std::string path;
        for (const ChartLoop& loop : loops_.of_faces[index]) {
            paths_.move_to(path, loop.front()->curve);
            for (const TrimCurve* c : loop) paths_.append(path, c->curve);
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
            paths_.move_to(path, piece->curve);
            paths_.append(path, piece->curve);
            edge(e, path, uses == 1);
            const CellEdge& from = cell_.edges[e];
            if (from.vertices.size() != 2) continue;
            place[from.vertices[piece->reversed ? 1 : 0]] = piece->curve.points.front().head<2>();
            place[from.vertices[piece->reversed ? 0 : 1]] = piece->curve.points.back().head<2>();
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
            index, paths_.number(point.x()), paths_.number(point.y()), paths_.number(dot_), v.radius,
            xml_escaped(who));
    }

    std::ostream& out_;
    const Cell& cell_;
    std::unordered_map<std::uint32_t, std::size_t> colours_;
    ChartLoops loops_;
    std::string buffer_;
    const std::vector<double> levels_;
    const std::vector<Contour> contours_;
    std::vector<LevelLine> level_lines_;  // of the picture
    TakenRoom words_;
    static constexpr double letter = 12, small_letter = 9, legend_height = 26;  // pixels
    static constexpr double wide = 0.65;                                        // of a letter's height
    bool has_lengths_ = false;  // the chart's coordinates are lengths
    double pixel_ = 1;          // of the picture as wide as it says, in the chart's units
    double size_ = 1;           // of the chart, its units
    double dot_ = 0;            // radius of a vertex
    SvgPaths paths_;
};

}  // namespace

void write_svg(std::ostream& out, const Cell& cell, const SvgOptions& options) {
    Picture picture(out, cell, options.contours);
    if (std::holds_alternative<Plane>(cell.scene.base))
        picture.draw();
    else
        picture.draw_unfolded();
}

}  // namespace vcell
