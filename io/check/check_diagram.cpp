#include "check_diagram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
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
#include "diagram_pairs.hpp"
#include "near_balls.hpp"
#include "near_others.hpp"
#include "space.hpp"

namespace vcell {

namespace {

std::string cell_name(std::uint32_t object) { return fmt::format("cells[{}]", object); }

using check::ImageIndex;

class DiagramCheck : check::CellsOfDiagram {
public:
    DiagramCheck(const StoredDiagram& diagram, const CheckOptions& options, unsigned threads)
        : CellsOfDiagram(diagram),
          diagram_(diagram),
          options_(options),
          threads_(threads),
          balls_(diagram.scene),
          near_(diagram.scene, balls_) {
        const Box& box = diagram.scene.box;
        rounding_ = check::file_rounding *
                    std::max({box.max.cwiseAbs().maxCoeff(), box.min.cwiseAbs().maxCoeff(), box.diagonal()});
        const std::vector<Object>& objects = diagram.scene.objects;
        for (std::uint32_t i = 0; i < objects.size(); ++i)
            if (!is_ball(i)) others_.push_back(i);
        find_hidden();
    }

    Certificate operator()() {
        check_cells();
        check_without_cells();
        check::certify_pairs(diagram_, balls_, near_, rounding_, certificate_);
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
        return candidates_around(balls_.search(i, reach), ball(i), reach);
    }
    Candidates candidates_around(check::NearBalls::Search near, const Sphere& ball, double reach) const {
        Candidates result;
        result.lack = std::move(near.lack);
        for (const auto& [object, moved] : near.found) result.found.push_back({object, moved});
        check::NearOthers::Search others = near_.search(ball.center, ball.radius + reach);
        if (result.lack.empty()) result.lack = std::move(others.lack);
        for (const auto& [object, shape] : others.found) {
            if (!(distance_of(shape, ball).lower() > reach)) result.found.push_back({object, shape});
        }
        std::ranges::sort(result.found, {}, &Candidate::object);
        return result;
    }

    // All objects but one, and where the box repeats all images that may be as near as that one to a point of
    // its cell in a box: no point is farther from it than half of `reach`.
    Candidates all_but(std::uint32_t object, const Box& box, double reach) const {
        Candidates result;
        if (diagram_.scene.is_periodic()) {
            const Sphere around{0.5 * (box.min + box.max), 0.5 * box.diagonal() * (1 + 0x1p-40)};
            const double far = std::min(reach, 2 * farthest_in(object, box));
            result = candidates_around(balls_.search(around, far), around, far);
            const Object& self = diagram_.scene.objects[object];
            std::erase_if(result.found, [&](const Candidate& found) {
                const auto* ball = std::get_if<Sphere>(&found.shape);
                return found.object == ObjectImage{object, {}} ||
                       (ball != nullptr && distance_of(self, *ball).lower() > far);
            });
            return result;
        }
        for (std::uint32_t i = 0; i < diagram_.scene.objects.size(); ++i)
            if (i != object) result.found.push_back({{i, {}}, diagram_.scene.objects[i]});
        return result;
    }
    static Interval distance_of(const Object& object, const Sphere& ball) {
        const check::Surface<Interval> surface(object);
        const Interval distance = surface.distance(check::to_vector<Interval>(ball.center));
        return (surface.kind == check::Surface<Interval>::Kind::plane ? check::magnitude(distance)
                                                                      : distance) -
               Interval(ball.radius);
    }
    // How far points of a box are from an object, at most: corners are the farthest.
    double farthest_in(std::uint32_t object, const Box& box) const {
        double most = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
            Vec3 p;
            for (unsigned k = 0; k < 3; ++k) p[k] = ((corner & 1U << k) != 0 ? box.max : box.min)[k];
            most = std::max(most, distance_of(diagram_.scene.objects[object], Sphere{p, 0}).upper());
        }
        return most;
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

    ObjectImage image_of(const Cell& stored, std::uint32_t named) const {
        const ObjectImage& image = stored.scene.images[named];
        return {image.number, near_.representative(image)};
    }
    // The cell with its scene: the objects that can reach it, and sites are places among these.
    Cell cell_among(const std::vector<Candidate>& near, std::uint32_t object, const Cell& stored) const {
        const DiagramScene& all = diagram_.scene;
        Cell cell = stored;
        Scene& scene = cell.scene;
        scene.base = base_of(object, stored);
        if (is_ball(object)) scene.box = room(ball(object));
        scene.units = all.units;
        scene.tolerance = all.tolerance;
        scene.probe = all.probe;
        for (const Candidate& found : near) scene.objects.push_back(found.shape);

        // What is not among them is no object.
        const auto place_of = [&](std::uint32_t named) {
            const ObjectImage image = image_of(stored, named);
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
        const Object& whose = diagram_.scene.objects[object];
        const auto* tube = std::get_if<Cylinder>(&whose);
        const std::optional<int> cut = tube != nullptr ? near_.cut_of(*tube, object) : std::nullopt;
        std::optional<Site> side;
        for_each_site(stored, [&](const Site& site) {
            if (site.kind == Site::Kind::BoxSide && repeats(site.index) &&
                !std::holds_alternative<Plane>(whose) && cut != static_cast<int>(site.index / 2))
                side = site;
        });
        if (side)
            certificate.refute("faces",
                               fmt::format("end at {}, along which the box repeats", to_string(*side)));
        if (!is_ball(object) && diagram_.scene.is_periodic()) {
            const std::string lack = near_.lack_of_room(stored.scene.box, object, stored.edges);
            if (!lack.empty()) certificate.leave_open("box", lack, HUGE_VAL);
        }
        const Measures& m = stored.measures;
        const double stated = 2 * (m.max_clearance + m.max_clearance_error);
        const double reach = std::isfinite(stated) ? std::max(0.0, stated) : HUGE_VAL;
        Candidates near = is_ball(object) ? candidates(object, std::min(reach, 2 * balls_.farthest()))
                                          : all_but(object, stored.scene.box, reach);
        if (!near.lack.empty()) {
            certificate.leave_open("scene", near.lack, HUGE_VAL);
            return certificate;
        }
        std::erase_if(near.found, [&](const Candidate& found) { return is_hidden(found.object.number); });
        for (std::uint32_t named = 0; named < stored.scene.images.size(); ++named)
            if (!std::ranges::binary_search(near.found, image_of(stored, named), {}, &Candidate::object))
                certificate.refute("sites", fmt::format("name object {}, which cannot reach the cell",
                                                        to_string(stored.scene.images[named])));
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

    // Is it an object without a cell that lies in another one, beyond a vessel's wall, or in an equal one of
    // a lower number? There it owns nothing.
    bool is_hidden(std::uint32_t i) const { return std::ranges::binary_search(hidden_, i); }

    void find_hidden() {
        const std::vector<Object>& objects = diagram_.scene.objects;
        for (std::uint32_t i = 0; i < objects.size(); ++i) {
            if (is_vessel(objects[i]) || !has_no_cell(i)) continue;
            const auto holds = [&](const Candidate& found) {
                return check::contains(found.shape, objects[i]) &&
                       (found.object.number < i || !check::contains(objects[i], found.shape));
            };
            const Candidates near = is_ball(i) ? candidates(i, 0) : holders(i);
            if (near.lack.empty() && std::ranges::any_of(near.found, holds)) hidden_.push_back(i);
        }
    }

    // What may hold an object that is no ball.
    Candidates holders(std::uint32_t i) const {
        const auto* tube = std::get_if<Cylinder>(&diagram_.scene.objects[i]);
        if (tube == nullptr || !diagram_.scene.is_periodic()) return all_but(i, diagram_.scene.box, HUGE_VAL);
        Candidates result = candidates_around({}, Sphere{tube->point, 0}, 0);
        std::erase_if(result.found, [&](const Candidate& found) { return found.object.number == i; });
        return result;
    }

    void check_without_cells() {
        for (std::uint32_t i = 0; i < diagram_.scene.objects.size(); ++i) {
            if (!has_no_cell(i)) continue;
            if (is_hidden(i))
                certificate_.prove(cell_name(i));
            else if (!is_ball(i))
                continue;
            else if (is_lacking(i))
                is_one_left_out_ = true;
            else if (const std::string lack = candidates(i, 0).lack; !lack.empty())
                certificate_.leave_open(cell_name(i), lack, HUGE_VAL);
            else if (is_beyond(i) && is_out_of_reach(i))
                certificate_.prove(cell_name(i));
            else if (is_beyond(i))
                leave_out(i);
            else
                certificate_.refute(cell_name(i), "the ball has no cell, and lies in no other object");
        }
    }

    // Does the ball's cell end at the probe before the box begins? Exactly; a box that repeats is everywhere
    // along its axes.
    bool is_out_of_reach(std::uint32_t i) const {
        const auto& [box, probe] = std::pair(diagram_.scene.box, diagram_.scene.probe);
        if (!probe) return false;
        Exact square(0.0);
        for (int k = 0; k < 3; ++k) {
            if (diagram_.scene.periodic[static_cast<std::size_t>(k)]) continue;
            const double c = ball(i).center[k], nearest = std::clamp(c, box.min[k], box.max[k]);
            const Exact along = Exact(c) - Exact(nearest);
            square += along * along;
        }
        const Exact reach = Exact(ball(i).radius) + Exact(*probe);
        return (square - reach * reach).sign() != Sign::Negative;
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
        if (is_hidden(i)) return true;
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
        // Where all objects but balls in others have cells nothing is left, but what a probe leaves.
        const bool are_all = !is_one_left_out_ && std::ranges::all_of(others_, [&](std::uint32_t other) {
            return is_whole(other);
        });
        const bool fills = are_all && !diagram_.scene.probe;
        if ((fills && sum.upper() < box.lower()) || box.upper() < sum.lower())
            certificate_.refute("volume",
                                fmt::format("the cells' volumes add up to {} within {}, the box has {}",
                                            sum.mid(), sum.radius(), box.mid()),
                                std::max(box.lower() - sum.upper(), sum.lower() - box.upper()));
        else if (fills)
            certificate_.prove("volume", (sum - box).magnitude());
        else
            certificate_.prove("volume", sum.radius(),
                               are_all ? "the rest of the box is farther from all objects than the probe"
                                       : "the rest of the box is nearest to what has no cell here");
    }

    const StoredDiagram& diagram_;
    const CheckOptions& options_;
    const unsigned threads_;
    const check::NearBalls balls_;
    const check::NearOthers near_;
    std::vector<std::uint32_t> others_;  // that are no balls
    std::vector<std::uint32_t> hidden_;  // without a cell, as they lie in something, ascending
    double rounding_ = 0;                // of points, in the scene's unit
    bool is_one_left_out_ = false;       // a ball that has no cell, though it may own something
    Certificate certificate_;
};

}  // namespace

Certificate certify(const StoredDiagram& diagram, const CheckOptions& options, unsigned threads) {
    return DiagramCheck(diagram, options, threads)();
}

}  // namespace vcell
