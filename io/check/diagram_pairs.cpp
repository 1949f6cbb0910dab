#include "diagram_pairs.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <ranges>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../core/numbers/interval.hpp"

namespace vcell::check {

namespace {

std::string text_of(const Vec3& p) { return fmt::format("({}, {}, {})", p.x(), p.y(), p.z()); }

ImageIndex joined(const ImageIndex& a, const ImageIndex& b, int sign = 1) {
    ImageIndex c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = static_cast<std::int16_t>(a[k] + sign * b[k]);
    return c;
}

// A site of a vertex, as seen from one of its cells: of objects also which image it is.
using PlacedSite = std::pair<Site, ImageIndex>;

std::string to_string(const PlacedSite& placed) {
    const auto& [site, image] = placed;
    return site.is_object() ? to_string(ObjectImage{site.index, image}) : to_string(site);
}

// That cells agree about what two of them share.
class DiagramPairs {
public:
    DiagramPairs(const StoredDiagram& diagram, const NearBalls& balls, const NearOthers& others,
                 double rounding)
        : diagram_(diagram), balls_(balls), others_(others), rounding_(rounding) {}

    void operator()(Certificate& certificate) const {
        std::map<Pair, std::array<Shared, 2>> pairs;
        for (const auto& [object, cell] : diagram_.cells) {
            const ObjectImage own{object, {}};
            const auto shared = [&](ObjectImage other) -> Shared& {
                ObjectImage back{own.number, joined({}, other.image, -1)};
                back.image = others_.representative(back, other.number);
                other.image = others_.representative(other, own.number);
                return std::pair(other.number, other.image) < std::pair(own.number, back.image)
                           ? pairs[{other.number, back}][1]
                           : pairs[{own.number, other}][0];
            };
            const std::vector<ObjectImage>& images = cell.scene.images;
            const auto is_shared = [&](const Site& site) {
                return site.is_object() && CellsOfDiagram(diagram_).is_paired(images[site.index].number);
            };
            for (const CellFace& f : cell.faces) {
                std::vector<Site> sites{f.site};
                sites.insert(sites.end(), f.extra_sites.begin(), f.extra_sites.end());
                for (const Site site : sites) {
                    if (!is_shared(site)) continue;
                    Shared& s = shared(images[site.index]);
                    ++s.faces;
                    s.area += Interval(f.area) + Interval(-f.area_error, f.area_error);
                }
            }
            for (const CellVertex& v : cell.vertices) {
                const std::vector<PlacedSite> sites = placed(object, cell, v.sites);
                if (is_on_cut(cell, v)) continue;
                for (const Site site : v.sites)
                    if (is_shared(site))
                        shared(images[site.index])
                            .vertices.push_back(in_period(
                                {sites, v.point, v.error, v.is_touching, cell.report.decisions.assumed > 0},
                                own, images[site.index]));
            }
        }
        for (auto& [pair, sides] : pairs) {
            const std::string where = fmt::format("pairs[{}, {}]", pair.first, vcell::to_string(pair.second));
            move(sides[1], pair.second.image);
            const std::vector<InParts> in_parts = cells_in_parts(pair);
            leave_whole(sides, in_parts);
            const bool is_cut = has_periods(pair.first) || has_periods(pair.second.number);
            std::string fault = in_parts.empty() ? fault_of(sides, is_cut) : std::string();
            if (fault.empty() && !(has_periods(pair.first) && has_periods(pair.second.number)))
                fault = fault_of_vertices(pair, sides);
            if (fault.empty())
                certificate.prove(where);
            else
                certificate.refute(where, fault);
        }
    }

private:
    // What a cell shares with another one.
    struct Shared {
        std::size_t faces = 0;
        Interval area{0.0};
        struct Vertex {
            std::vector<PlacedSite> sites;  // the cell's own object among them
            Vec3 point;
            double error;
            bool is_touching;  // nothing bounds where it is along bisectors that touch
            bool has_assumed;  // its cell has taken coincidences for granted
        };
        std::vector<Vertex> vertices;
    };
    // An object, and another one or an image as seen from it: the lower number first, and of a ball's own
    // images the greater one of two opposite ones.
    using Pair = std::pair<std::uint32_t, ObjectImage>;

    bool has_periods(std::uint32_t object) const { return !others_.periods(object).empty(); }
    // Is it on a side across which the box repeats, where one period of a cell ends?
    bool is_on_cut(const Cell& cell, const CellVertex& v) const {
        return std::ranges::any_of(v.sites, [&](Site site) {
            site = side_at_end(cell.scene, site);
            return site.kind == Site::Kind::BoxSide && diagram_.scene.periodic[site.index / 2];
        });
    }
    // A vertex of an object's cell is one of a pair with an image that stands for others: where that is, seen
    // from the object, which is where it was after its periods. Of the two one has no periods.
    Shared::Vertex in_period(Shared::Vertex v, const ObjectImage& own, const ObjectImage& other) const {
        if (!has_periods(own.number) || has_periods(other.number)) return v;
        ObjectImage back{own.number, joined({}, other.image, -1)};
        back.image = others_.representative(back, other.number);
        const ImageIndex ahead = others_.representative(other, own.number);
        const bool is_second = std::pair(other.number, ahead) < std::pair(own.number, back.image);
        move(v, is_second ? joined({}, joined(back.image, other.image), -1) : joined(ahead, other.image, -1));
        return v;
    }

    // The sites of one of a cell's elements and the cell's own object, ascending.
    std::vector<PlacedSite> placed(std::uint32_t object, const Cell& cell,
                                   std::span<const Site> of_element) const {
        std::vector<PlacedSite> sites{{Site::object(object), {}}};
        for (const Site site : of_element) {
            if (!site.is_object()) {
                sites.emplace_back(side_at_end(cell.scene, site), ImageIndex{});
            } else {
                const ObjectImage& image = cell.scene.images[site.index];
                sites.emplace_back(Site::object(image.number), others_.representative(image));
            }
        }
        std::ranges::sort(sites);
        return sites;
    }

    // Is a point certainly within a part of a cell that comes in parts?
    bool is_in_part(const Cell& cell, const Vec3& p, double error) const {
        const Vec3 along = std::get<Cylinder>(cell.scene.base).axis.stableNormalized();
        return std::ranges::any_of(cell.parts, [&](const CellPart& part) {
            const double room = error + rounding_;
            return along.dot(p - part.ends[0]) > room && along.dot(part.ends[1] - p) > room;
        });
    }
    // Planes may have two, which are judged together: both have vertices with the other object.
    auto cells_of(std::uint32_t object) const {
        return std::ranges::equal_range(diagram_.cells, object, {}, [](const auto& c) { return c.first; });
    }
    // A cell of the pair that comes in parts, and where it is as seen from the first one.
    struct InParts {
        const Cell* cell;
        ObjectImage object;
    };
    std::vector<InParts> cells_in_parts(const Pair& pair) const {
        std::vector<InParts> found;
        for (const ObjectImage& object : {ObjectImage{pair.first, {}}, pair.second})
            for (const auto& [number, cell] : cells_of(object.number))
                if (!cell.parts.empty()) found.push_back({&cell, object});
        return found;
    }
    // Leaves of the vertices of two cells what both must have, as neither leaves it out.
    void leave_whole(std::array<Shared, 2>& sides, const std::vector<InParts>& in_parts) const {
        for (Shared& side : sides)
            std::erase_if(side.vertices, [&](const Shared::Vertex& v) {
                return std::ranges::any_of(in_parts, [&](const InParts& whose) {
                    return !is_in_part(*whose.cell, in_cell(whose, v.point), v.error);
                });
            });
    }
    // How many edges of the box a point is to be moved by into the file's period of an object's cell.
    ImageIndex into_period(const Cell& cell, std::uint32_t object, const Vec3& p) const {
        ImageIndex moves{};
        const auto* tube = std::get_if<Cylinder>(&cell.scene.base);
        const std::optional<int> cut = tube != nullptr ? others_.cut_of(*tube, object) : std::nullopt;
        if (!cut) return moves;
        const ImageIndex& period = others_.periods(object).front();
        const Box& box = cell.scene.box;
        const double middle = 0.5 * (box.min[*cut] + box.max[*cut]);
        const auto times = static_cast<int>(std::round((middle - p[*cut]) / balls_.shift(period)[*cut]));
        for (std::size_t k = 0; k < 3; ++k) moves[k] = static_cast<std::int16_t>(times * period[k]);
        return moves;
    }
    // Where a point is in the file's period of a cell.
    Vec3 in_cell(const InParts& whose, const Vec3& point) const {
        const Vec3 p = point - balls_.shift(whose.object.image);
        return p + balls_.shift(into_period(*whose.cell, whose.object.number, p));
    }

    // The vertices of the second of two cells as the first one sees them.
    void move(Shared& side, const ImageIndex& image) const {
        for (Shared::Vertex& v : side.vertices) move(v, image);
    }
    void move(Shared::Vertex& v, const ImageIndex& image) const {
        if (image == ImageIndex{}) return;
        const Vec3 by = balls_.shift(image);
        v.error += file_rounding * (v.point.norm() + by.norm());
        v.point += by;
        for (auto& [site, of] : v.sites)
            if (site.is_object()) of = others_.representative({site.index, joined(of, image)});
        std::ranges::sort(v.sites);
    }
    // A vertex of the first of two cells as the second one sees it.
    Shared::Vertex moved_back(Shared::Vertex v, ImageIndex image) const {
        for (auto& i : image) i = static_cast<std::int16_t>(-i);
        move(v, image);
        return v;
    }

    static std::string fault_of(const std::array<Shared, 2>& sides, bool is_cut) {
        const auto& [a, b] = sides;
        if (is_cut ? (a.faces == 0) != (b.faces == 0) : a.faces != b.faces)
            return fmt::format("the two cells have {} and {} faces between them", a.faces, b.faces);
        if (a.faces > 0 && (a.area.upper() < b.area.lower() || b.area.upper() < a.area.lower()))
            return fmt::format("the two cells have areas of {} and {} between them", a.area.mid(),
                               b.area.mid());
        return {};
    }

    std::string fault_of_vertices(const Pair& pair, std::array<Shared, 2>& sides) const {
        auto& [a, b] = sides;
        // Few vertices have the same objects: only these are compared. A side of the box may be a site of one
        // cell alone, as the other one comes to it nowhere else; that it is there its own cell's check tells.
        const auto by_objects = [](const Shared::Vertex& v, const Shared::Vertex& w) {
            const auto is_object = [](const PlacedSite& s) { return s.first.is_object(); };
            return std::ranges::lexicographical_compare(v.sites | std::views::filter(is_object),
                                                        w.sites | std::views::filter(is_object));
        };
        std::ranges::stable_sort(a.vertices, by_objects);
        std::ranges::stable_sort(b.vertices, by_objects);
        std::vector<char> is_taken(b.vertices.size(), 0);
        const auto range = [&](const std::vector<Shared::Vertex>& in, const Shared::Vertex& v) {
            return std::equal_range(in.begin(), in.end(), v, by_objects);
        };
        const auto are_near = [&](const Shared::Vertex& v, const Shared::Vertex& w) {
            return (v.point - w.point).norm() <= v.error + w.error + rounding_;
        };
        // Where bisectors touch a vertex is a double one, which one cell may have once and the other one
        // twice; and what a cell has taken to meet in one point it may have more often than there is.
        const auto is_double = [&](const Shared::Vertex& v, const std::vector<Shared::Vertex>& in) {
            const auto [first, last] = range(in, v);
            return std::any_of(first, last, [&](const Shared::Vertex& w) {
                return v.is_touching || w.is_touching || ((v.has_assumed || w.has_assumed) && are_near(v, w));
            });
        };
        for (const Shared::Vertex& v : a.vertices) {
            const auto [first, last] = range(b.vertices, v);
            const auto twin = std::find_if(first, last, [&](const Shared::Vertex& w) {
                return !is_taken[&w - b.vertices.data()] && are_near(v, w);
            });
            if (twin != last)
                is_taken[twin - b.vertices.begin()] = 1;
            else if (!is_double(v, b.vertices) &&
                     !lies_on_edge_or_vertex(pair, pair.second.number, moved_back(v, pair.second.image)))
                return only_one_has(v);
        }
        for (std::size_t i = 0; i < b.vertices.size(); ++i)
            if (is_taken[i] == 0 && !is_double(b.vertices[i], a.vertices) &&
                !lies_on_edge_or_vertex(pair, pair.first, b.vertices[i]))
                return only_one_has(b.vertices[i]);
        return {};
    }
    static std::string only_one_has(const Shared::Vertex& v) {
        std::string sites;
        for (const PlacedSite& s : v.sites) sites += (sites.empty() ? "" : ", ") + to_string(s);
        return fmt::format("only one of the two cells has the vertex of {} at {}", sites, text_of(v.point));
    }

    // Does a vertex of one cell of the pair lie on an edge of a cell of `object`, the other one, that belongs
    // to sites of it? Each cell has a cap of its own, and what touches that or a side of the box in a point
    // is in no label: a vertex on a cap may lie on any such edge, one on a side on those between objects.
    // Where scenes moved, it may lie on any such edge, or at any vertex, as others that tie there may be
    // nearer.
    bool lies_on_edge_or_vertex(const Pair& pair, std::uint32_t object, const Shared::Vertex& v) const {
        const auto is_of = [](Site::Kind kind) {
            return [kind](const PlacedSite& s) { return s.first.kind == kind; };
        };
        const bool have_moved = has_moved(pair.first) || has_moved(pair.second.number);
        const bool is_any = have_moved || std::ranges::any_of(v.sites, is_of(Site::Kind::Cap));
        if (!is_any && std::ranges::none_of(v.sites, is_of(Site::Kind::BoxSide))) return false;
        for (const auto& [number, cell] : cells_of(object)) {
            Shared::Vertex seen = v;
            move(seen, into_period(cell, object, v.point));
            for (const CellEdge& e : cell.edges)
                if ((is_any || std::ranges::all_of(e.sites, &Site::is_object)) &&
                    std::ranges::includes(seen.sites, placed(object, cell, e.sites)) &&
                    least_distance(e.curve, seen.point) <= seen.error + e.error + rounding_)
                    return true;
            if (have_moved && std::ranges::any_of(cell.vertices, [&](const CellVertex& w) {
                    return (seen.point - w.point).norm() <= seen.error + w.error + rounding_;
                }))
                return true;
        }
        return false;
    }
    bool has_moved(std::uint32_t object) const {
        return std::ranges::any_of(cells_of(object), [](const auto& c) { return c.second.report.moved > 0; });
    }
    // An upper bound, but for rounding, of the distance of a point from a curve: the least one of some
    // points, and of what golden sections beside that come to.
    static double least_distance(const RationalCurve3& curve, const Vec3& p) {
        constexpr int parts = 32, sections = 60;
        constexpr double golden = 0.6180339887498949;
        const double begin = curve.domain_begin(), step = (curve.domain_end() - begin) / parts;
        const auto at = [&](double t) { return (curve.evaluate(t) - p).norm(); };
        int best = 0;
        for (int i = 1; i <= parts; ++i)
            if (at(begin + i * step) < at(begin + best * step)) best = i;
        double low = begin + std::max(0, best - 1) * step, high = begin + std::min(parts, best + 1) * step;
        double least = at(begin + best * step);
        for (int i = 0; i < sections; ++i) {
            const double s = high - golden * (high - low), t = low + golden * (high - low);
            const double at_s = at(s), at_t = at(t);
            least = std::min({least, at_s, at_t});
            (at_s < at_t ? high : low) = at_s < at_t ? t : s;
        }
        return least;
    }

    const StoredDiagram& diagram_;
    const NearBalls& balls_;
    const NearOthers& others_;
    const double rounding_;  // of points, in the scene's unit
};

}  // namespace

void certify_pairs(const StoredDiagram& diagram, const NearBalls& balls, const NearOthers& others,
                   double rounding, Certificate& certificate) {
    DiagramPairs(diagram, balls, others, rounding)(certificate);
}

}  // namespace vcell::check
