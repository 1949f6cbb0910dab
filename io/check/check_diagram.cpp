#include "check_diagram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "../../core/errors.hpp"
#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/threads.hpp"
#include "containment.hpp"
#include "near_balls.hpp"
#include "space.hpp"

namespace vcell {

namespace {

// Numbers of a file are rounded (check.hpp).
constexpr double file_rounding = 0x1p-44;

std::string cell_name(std::uint32_t object) { return fmt::format("cells[{}]", object); }

std::string text_of(const Vec3& p) { return fmt::format("({}, {}, {})", p.x(), p.y(), p.z()); }

using check::ImageIndex;
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

// Which objects have cells.
class CellsOfDiagram {
public:
    explicit CellsOfDiagram(const StoredDiagram& diagram) : diagram_(diagram) {}

    bool is_ball(std::uint32_t i) const { return std::holds_alternative<Sphere>(diagram_.scene.objects[i]); }
    const Sphere& ball(std::uint32_t i) const { return std::get<Sphere>(diagram_.scene.objects[i]); }
    bool has_no_cell(std::uint32_t j) const {
        return !std::ranges::binary_search(diagram_.cells, j, {}, [](const auto& c) { return c.first; });
    }
    // Is a ball's centre on a side of the box or beyond it? There it may have no cell in the file, though it
    // owns something. The box does not repeat along an axis along which it is.
    bool is_beyond(std::uint32_t i) const {
        const Vec3& c = ball(i).center;
        for (int k = 0; k < 3; ++k)
            if (!diagram_.scene.periodic[static_cast<std::size_t>(k)] &&
                !(c[k] > diagram_.scene.box.min[k] && c[k] < diagram_.scene.box.max[k]))
                return true;
        return false;
    }
    // Numbers of no object are of pairs, too, to be refuted. Balls without a cell own nothing.
    bool is_paired(std::uint32_t i) const {
        return i >= diagram_.scene.objects.size() || !has_no_cell(i) || (is_ball(i) && !is_beyond(i));
    }

private:
    const StoredDiagram& diagram_;
};

// That cells agree about what two of them share.
class DiagramPairs {
public:
    DiagramPairs(const StoredDiagram& diagram, const check::NearBalls& balls, double rounding)
        : diagram_(diagram), balls_(balls), rounding_(rounding) {}

    void operator()(Certificate& certificate) const {
        std::map<Pair, std::array<Shared, 2>> pairs;
        for (const auto& [object, cell] : diagram_.cells) {
            const ObjectImage own{object, {}};
            const auto shared = [&](const ObjectImage& other) -> Shared& {
                return own < other ? pairs[{own.number, other}][0]
                                   : pairs[{other.number, {own.number, joined({}, other.image, -1)}}][1];
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
                std::vector<PlacedSite> sites{{Site::object(object), {}}};
                for (const Site site : v.sites) {
                    if (!site.is_object())
                        sites.emplace_back(side_at(cell, site), ImageIndex{});
                    else
                        sites.emplace_back(Site::object(images[site.index].number), images[site.index].image);
                }
                std::ranges::sort(sites);
                for (const Site site : v.sites)
                    if (is_shared(site))
                        shared(images[site.index]).vertices.push_back({sites, v.point, v.error});
            }
        }
        for (auto& [pair, sides] : pairs) {
            const std::string where = fmt::format("pairs[{}, {}]", pair.first, vcell::to_string(pair.second));
            move(sides[1], pair.second.image);
            const std::vector<const Cell*> in_parts = cells_in_parts(pair);
            leave_whole(sides, in_parts);
            if (const std::string fault = fault_of(sides, !in_parts.empty()); !fault.empty())
                certificate.refute(where, fault);
            else
                certificate.prove(where);
        }
    }

private:
    // What a cell shares with one ball.
    struct Shared {
        std::size_t faces = 0;
        Interval area{0.0};
        struct Vertex {
            std::vector<PlacedSite> sites;  // the cell's own ball among them
            Vec3 point;
            double error;
        };
        std::vector<Vertex> vertices;
    };
    // An object, and another one or an image as seen from it: the lower number first, and of a ball's own
    // images the greater one of two opposite ones.
    using Pair = std::pair<std::uint32_t, ObjectImage>;

    // The side of the box that ends a tube along one of its axes, which its cell has for an end.
    static Site side_at(const Cell& cell, const Site& site) {
        const auto* tube = std::get_if<Cylinder>(&cell.scene.base);
        if (tube == nullptr || site.kind != Site::Kind::End || !cell.parts.empty()) return site;
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (tube->axis[(k + 1) % 3] != 0 || tube->axis[(k + 2) % 3] != 0) continue;
            return Site::box_side(2 * k + (tube->axis[k] > 0 ? site.index : 1 - site.index));
        }
        return site;
    }

    // Is a point certainly within a part of a cell that comes in parts?
    bool is_in_part(const Cell& cell, const Vec3& p, double error) const {
        const Vec3 along = std::get<Cylinder>(cell.scene.base).axis.stableNormalized();
        return std::ranges::any_of(cell.parts, [&](const CellPart& part) {
            const double room = error + rounding_;
            return along.dot(p - part.ends[0]) > room && along.dot(part.ends[1] - p) > room;
        });
    }
    // The cells of two objects that come in parts.
    std::vector<const Cell*> cells_in_parts(const Pair& pair) const {
        std::vector<const Cell*> found;
        for (const std::uint32_t object : {pair.first, pair.second.number})
            for (const auto& [number, cell] :
                 std::ranges::equal_range(diagram_.cells, object, {}, [](const auto& c) { return c.first; }))
                if (!cell.parts.empty()) found.push_back(&cell);
        return found;
    }
    // Leaves of the vertices of two cells what both must have, as neither leaves it out.
    void leave_whole(std::array<Shared, 2>& sides, const std::vector<const Cell*>& in_parts) const {
        for (Shared& side : sides)
            std::erase_if(side.vertices, [&](const Shared::Vertex& v) {
                return std::ranges::any_of(
                    in_parts, [&](const Cell* cell) { return !is_in_part(*cell, v.point, v.error); });
            });
    }

    // The vertices of the second of two cells as the first one sees them.
    void move(Shared& side, const ImageIndex& image) const {
        if (image == ImageIndex{}) return;
        const Vec3 by = balls_.shift(image);
        for (Shared::Vertex& v : side.vertices) {
            v.error += file_rounding * (v.point.norm() + by.norm());
            v.point += by;
            for (auto& [site, of] : v.sites)
                if (site.is_object()) of = joined(of, image);
            std::ranges::sort(v.sites);
        }
    }

    std::string fault_of(std::array<Shared, 2>& sides, bool is_cut) const {
        auto& [a, b] = sides;
        if (!is_cut && a.faces != b.faces)
            return fmt::format("the two cells have {} and {} faces between them", a.faces, b.faces);
        if (!is_cut && a.faces > 0 && (a.area.upper() < b.area.lower() || b.area.upper() < a.area.lower()))
            return fmt::format("the two cells have areas of {} and {} between them", a.area.mid(),
                               b.area.mid());
        if (a.vertices.size() != b.vertices.size())
            return fmt::format("the two cells have {} and {} vertices with both objects", a.vertices.size(),
                               b.vertices.size());
        // Few vertices have the same sites: only these are compared.
        const auto by_sites = [](const Shared::Vertex& v, const Shared::Vertex& w) {
            return v.sites < w.sites;
        };
        std::ranges::stable_sort(a.vertices, by_sites);
        std::ranges::stable_sort(b.vertices, by_sites);
        std::vector<char> is_taken(b.vertices.size(), 0);
        for (const Shared::Vertex& v : a.vertices) {
            const auto [first, last] = std::equal_range(b.vertices.begin(), b.vertices.end(), v, by_sites);
            const auto twin = std::find_if(first, last, [&](const Shared::Vertex& w) {
                return !is_taken[&w - b.vertices.data()] &&
                       (v.point - w.point).norm() <= v.error + w.error + rounding_;
            });
            if (twin == last) {
                std::string sites;
                for (const PlacedSite& s : v.sites) sites += (sites.empty() ? "" : ", ") + to_string(s);
                return fmt::format("only one of the two cells has the vertex of {} at {}", sites,
                                   text_of(v.point));
            }
            is_taken[twin - b.vertices.begin()] = 1;
        }
        return {};
    }

    const StoredDiagram& diagram_;
    const check::NearBalls& balls_;
    const double rounding_;  // of points, in the scene's unit
};

class DiagramCheck : CellsOfDiagram {
public:
    DiagramCheck(const StoredDiagram& diagram, const CheckOptions& options, unsigned threads)
        : CellsOfDiagram(diagram),
          diagram_(diagram),
          options_(options),
          threads_(threads),
          balls_(diagram.scene) {
        const Box& box = diagram.scene.box;
        rounding_ = file_rounding *
                    std::max({box.max.cwiseAbs().maxCoeff(), box.min.cwiseAbs().maxCoeff(), box.diagonal()});
        const std::vector<Object>& objects = diagram.scene.objects;
        for (std::uint32_t i = 0; i < objects.size(); ++i)
            if (!is_ball(i)) others_.emplace_back(i, check::Surface<Interval>(objects[i]));
    }

    Certificate operator()() {
        check_cells();
        check_without_cells();
        DiagramPairs(diagram_, balls_, rounding_)(certificate_);
        check_volume();
        return std::move(certificate_);
    }

private:
    // A ball, where its image is, or another object.
    struct Candidate {
        ObjectImage object;
        Object shape;
    };
    struct Candidates {
        std::vector<Candidate> found;  // ascending
        std::string lack;              // as of NearBalls::Search
    };
    // An object as base: a plane is turned to the one side that the cell is on.
    Object base_of(std::uint32_t object, const Cell& stored) const {
        const Object& whose = diagram_.scene.objects[object];
        const auto* plane = std::get_if<Plane>(&whose);
        const auto* as_base = std::get_if<Plane>(&stored.scene.base);
        if (plane == nullptr || as_base == nullptr || !(plane->normal.dot(as_base->normal) < 0)) return whose;
        return Plane{plane->point, -plane->normal};
    }
    std::string name_of(std::uint32_t object, const Cell& stored) const {
        const Object& whose = diagram_.scene.objects[object];
        if (!std::holds_alternative<Plane>(whose)) return cell_name(object);
        return fmt::format("cells[{}{}]", object, base_of(object, stored) == whose ? '+' : '-');
    }
    bool repeats(std::uint32_t side) const { return diagram_.scene.periodic[side / 2]; }

    // ---- Cells ----

    // Where the box repeats, one about the ball that its cell lies in: what is proved to have no face on a
    // side of it ends before it gets there, in whatever box. Half of an edge is as far as a ball's own images
    // let its cell reach along an axis, half of all of them together where they lean; sides that are a
    // quarter farther are out of sight.
    Box room(const Sphere& ball) const {
        const DiagramScene& scene = diagram_.scene;
        Box room = scene.box;
        const bool leans = scene.tilt != std::array{0.0, 0.0, 0.0};
        const auto edge = [&](int k) {
            ImageIndex one{};
            one[static_cast<std::size_t>(k)] = 1;
            return balls_.shift(one).norm();
        };
        for (int k = 0; k < 3; ++k) {
            if (!scene.periodic[static_cast<std::size_t>(k)]) continue;
            const double half = 0.625 * (leans ? edge(0) + edge(1) + edge(2) : edge(k));
            room.min[k] = ball.center[k] - half;
            room.max[k] = ball.center[k] + half;
        }
        return room;
    }

    // All objects that may be nearer to the surface of ball i than `reach`.
    Candidates candidates(std::uint32_t i, double reach) const {
        Candidates result;
        check::NearBalls::Search near = balls_.search(i, reach);
        result.lack = std::move(near.lack);
        for (const auto& [object, moved] : near.found) result.found.push_back({object, moved});
        for (const auto& [number, surface] : others_) {
            const Interval distance = surface.distance(check::to_vector<Interval>(ball(i).center));
            const bool is_plane = surface.kind == check::Surface<Interval>::Kind::plane;
            const Interval room =
                (is_plane ? check::magnitude(distance) : distance) - Interval(ball(i).radius);
            if (!(room.lower() > reach))
                result.found.push_back({{number, {}}, diagram_.scene.objects[number]});
        }
        std::ranges::sort(result.found, {}, &Candidate::object);
        return result;
    }

    // All objects but one.
    Candidates all_but(std::uint32_t object) const {
        Candidates result;
        for (std::uint32_t i = 0; i < diagram_.scene.objects.size(); ++i)
            if (i != object) result.found.push_back({{i, {}}, diagram_.scene.objects[i]});
        return result;
    }

    // What is said of objects by their places among the candidates, said by their numbers.
    static std::string with_numbers(const std::string& text, const std::vector<Candidate>& near) {
        static constexpr std::string_view word = "object ";
        std::string result;
        for (std::size_t at = 0;;) {
            const std::size_t found = text.find(word, at);
            if (found == text.npos) return result.append(text, at);
            const std::size_t behind = found + word.size();
            result.append(text, at, behind - at);
            at = behind;
            std::uint32_t place = 0;
            const char* const end = text.data() + text.size();
            const auto [after, error] = std::from_chars(text.data() + behind, end, place);
            if (error != std::errc() || place >= near.size()) continue;
            result += to_string(near[place].object);
            at = static_cast<std::size_t>(after - text.data());
        }
    }

    // The cell with its scene: the objects that can reach it, and sites are places among these.
    Cell cell_among(const std::vector<Candidate>& near, std::uint32_t object, const Cell& stored) const {
        const DiagramScene& all = diagram_.scene;
        Cell cell = stored;
        Scene& scene = cell.scene;
        scene.base = base_of(object, stored);
        scene.box = is_ball(object) ? room(ball(object)) : all.box;
        scene.units = all.units;
        scene.tolerance = all.tolerance;
        for (const Candidate& found : near) scene.objects.push_back(found.shape);

        // What is not among them is no object.
        const auto place_of = [&](std::uint32_t named) {
            const ObjectImage& image = stored.scene.images[named];
            const auto at = std::ranges::lower_bound(near, image, {}, &Candidate::object);
            return at != near.end() && at->object == image ? static_cast<std::uint32_t>(at - near.begin())
                                                           : UINT32_MAX - 1;
        };
        std::vector<std::uint32_t> places(stored.scene.images.size());
        for (std::uint32_t n = 0; n < places.size(); ++n) places[n] = place_of(n);
        for_each_site(cell, [&](Site& site) {
            if (site.is_object()) site.index = places[site.index];
        });
        for (std::uint32_t& n : cell.neighbors) n = places[n];
        return cell;
    }

    Certificate certificate_of(std::uint32_t object, const Cell& stored) const {
        Certificate certificate;
        std::optional<Site> side;
        for_each_site(stored, [&](const Site& site) {
            if (site.kind == Site::Kind::BoxSide && repeats(site.index)) side = site;
        });
        if (side)
            certificate.refute("faces",
                               fmt::format("end at {}, along which the box repeats", to_string(*side)));
        const Measures& m = stored.measures;
        const double stated = 2 * (m.max_clearance + m.max_clearance_error);
        const double reach =
            std::min(std::isfinite(stated) ? std::max(0.0, stated) : HUGE_VAL, 2 * balls_.farthest());
        Candidates near = is_ball(object) ? candidates(object, reach) : all_but(object);
        if (!near.lack.empty()) {
            certificate.leave_open("scene", near.lack, HUGE_VAL);
            return certificate;
        }
        // What is in another ball, or beyond a vessel's wall, owns nothing; of equal ones the first has the
        // cell.
        std::erase_if(near.found, [&](const Candidate& found) {
            return std::holds_alternative<Sphere>(found.shape) && has_no_cell(found.object.number) &&
                   !is_beyond(found.object.number);
        });
        for (const ObjectImage& image : stored.scene.images)
            if (!std::ranges::binary_search(near.found, image, {}, &Candidate::object))
                certificate.refute(
                    "sites", fmt::format("name object {}, which cannot reach the cell", to_string(image)));
        try {
            const Cell cell = cell_among(near.found, object, stored);
            validate(cell.scene);
            Certificate of_cell = certify(cell, options_);
            certificate.distance = of_cell.distance;
            for (Element& e : of_cell.elements) {
                if (!e.what.empty()) e.what = with_numbers(e.what, near.found);
                certificate.add(std::move(e));
            }
        } catch (const InputError& e) {
            certificate.refute("scene", e.what());
        }
        return certificate;
    }

    void check_cells() {
        in_order(
            diagram_.cells.size(), threads_,
            [&](std::size_t k) {
                const auto& [object, stored] = diagram_.cells[k];
                return certificate_of(object, stored);
            },
            [&](std::size_t k, Certificate of_cell) {
                const std::string name = name_of(diagram_.cells[k].first, diagram_.cells[k].second);
                certificate_.distance = std::max(certificate_.distance, of_cell.distance);
                for (Element& e : of_cell.elements) {
                    e.where = name + "." + e.where;
                    certificate_.add(std::move(e));
                }
            });
    }

    void check_without_cells() {
        for (std::uint32_t i = 0; i < diagram_.scene.objects.size(); ++i) {
            if (!is_ball(i) || !has_no_cell(i)) continue;
            const auto holds = [&](const Candidate& found) {
                return check::contains(found.shape, ball(i)) &&
                       (found.object.number < i || !check::contains(ball(i), found.shape));
            };
            const Candidates near = candidates(i, 0);
            if (!near.lack.empty())
                certificate_.leave_open(cell_name(i), near.lack, HUGE_VAL);
            else if (std::ranges::any_of(near.found, holds))
                certificate_.prove(cell_name(i));
            else if (is_beyond(i))
                leave_out(i);
            else
                certificate_.refute(cell_name(i), "the ball has no cell, and lies in no other object");
        }
    }

    void leave_out(std::uint32_t i) {
        is_one_left_out_ = true;
        certificate_.leave_open(cell_name(i), "the ball's centre is beyond the box, and it has no cell here",
                                HUGE_VAL);
    }

    // ---- The box ----

    // On how many sides of a plane there is nothing of the box, exactly.
    int sides_without_box(const Plane& plane) const {
        const Box& box = diagram_.scene.box;
        std::array<bool, 2> has_some{false, false};
        for (unsigned corner = 0; corner < 8; ++corner) {
            Exact height(0.0);
            for (unsigned k = 0; k < 3; ++k) {
                const double p = ((corner & 1u << k) != 0 ? box.max : box.min)[k];
                height += Exact(plane.normal[k]) * (Exact(p) - Exact(plane.point[k]));
            }
            has_some[0] = has_some[0] || height.sign() == Sign::Positive;
            has_some[1] = has_some[1] || height.sign() == Sign::Negative;
        }
        return !has_some[0] + !has_some[1];
    }
    // Has an object that is no ball all of its cells here?
    bool is_whole(std::uint32_t i) const {
        const auto cells =
            std::ranges::equal_range(diagram_.cells, i, {}, [](const auto& c) { return c.first; });
        const auto* plane = std::get_if<Plane>(&diagram_.scene.objects[i]);
        return std::ssize(cells) == (plane != nullptr ? 2 - sides_without_box(*plane) : 1);
    }

    void check_volume() {
        Interval sum(0.0), box(1.0);
        for (const auto& [object, cell] : diagram_.cells) {
            const Measures& m = cell.measures;
            sum += Interval(m.volume) + Interval(-m.volume_error, m.volume_error);
        }
        for (int k = 0; k < 3; ++k)
            box *= Interval(diagram_.scene.box.max[k]) - Interval(diagram_.scene.box.min[k]);
        // Where all objects but balls in others have cells nothing is left.
        const bool fills = !is_one_left_out_ && std::ranges::all_of(others_, [&](const auto& other) {
            return is_whole(other.first);
        });
        if ((fills && sum.upper() < box.lower()) || box.upper() < sum.lower())
            certificate_.refute("volume",
                                fmt::format("the cells' volumes add up to {} within {}, the box has {}",
                                            sum.mid(), sum.radius(), box.mid()),
                                std::max(box.lower() - sum.upper(), sum.lower() - box.upper()));
        else if (fills)
            certificate_.prove("volume", (sum - box).magnitude());
        else
            certificate_.prove("volume", sum.radius(),
                               "the rest of the box is nearest to what has no cell here");
    }

    const StoredDiagram& diagram_;
    const CheckOptions& options_;
    const unsigned threads_;
    const check::NearBalls balls_;
    std::vector<std::pair<std::uint32_t, check::Surface<Interval>>> others_;  // that are no balls
    double rounding_ = 0;           // of points, in the scene's unit
    bool is_one_left_out_ = false;  // a ball that has no cell, though it may own something
    Certificate certificate_;
};

}  // namespace

Certificate certify(const StoredDiagram& diagram, const CheckOptions& options, unsigned threads) {
    return DiagramCheck(diagram, options, threads)();
}

}  // namespace vcell
