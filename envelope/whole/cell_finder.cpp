#include "cell_finder.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "../../core/errors.hpp"
#include "../../primitives/bases/nested_balls.hpp"
#include "../../primitives/bases/solids.hpp"
#include "../complete_measures.hpp"
#include "../object_distance.hpp"
#include "../voronoi_cell.hpp"

namespace vcell::whole {

namespace {

using Kind = InputError::Kind;
using Image = DecidedDiagram::Image;
constexpr Image here{0, 0, 0};

// ---- Distances --------------------------------------------------------------------------------------

// A lower bound of the distance between an object and a ball's surface; negative where they overlap.
double least_distance(const Object& object, const Sphere& ball) {
    // Beyond the rounding of a handful of products of coordinates and unit vectors.
    constexpr double rounding = 0x1p-46;
    const auto size_of = [](const auto& o) {
        if constexpr (requires { o.center; })
            return o.center.cwiseAbs().sum() + o.radius;
        else if constexpr (requires { o.radius; })
            return o.point.cwiseAbs().sum() + o.radius;
        else
            return o.point.cwiseAbs().sum();
    };
    return distance_from(object, ball.center) - ball.radius -
           rounding * (std::visit(size_of, object) + size_of(ball));
}

// A ball that lies beyond a vessel's wall, or touches it from there, is nowhere nearer than the wall.
bool is_beyond_wall(const Object& object, const Sphere& ball) {
    if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        const ExactVector way = ExactVector(ball.center) - ExactVector(vessel->center);
        const Exact reach = Exact(vessel->radius) + ball.radius;
        return (dot(way, way) - reach * reach).sign() != Sign::Negative;
    }
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) {
        const Vec3 a = scaled_axis(vessel->axis), &p = vessel->point, &c = ball.center;
        return is_beside({p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), vessel->radius}, c.x(), c.y(), c.z(),
                         ball.radius);
    }
    return false;
}

bool holds(const Box& box, const Vec3& p) {
    return (p.array() > box.min.array()).all() && (p.array() < box.max.array()).all();
}

}  // namespace

// ---- The scene --------------------------------------------------------------------------------------

DecidedDiagram::DecidedDiagram(const DiagramScene& scene) : scene_(scene) {
    validate_diagram();
    if (scene_.is_periodic()) snap();
    edges_ = scene_.edges();
    to_unit_ = edges_.inverse();
    std::vector<BallTree::Entry> balls;
    for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
        if (is_ball(i))
            balls.push_back({ball(i), i});
        else
            others_.push_back(i);
        has_vessels_ = has_vessels_ || is_vessel(scene_.objects[i]);
    }
    tree_ = BallTree(balls);
    hidden_.resize(scene_.objects.size());
    find_hidden();
    if (std::erase_if(balls, [&](const BallTree::Entry& e) { return !hidden_[e.number].empty(); }) > 0)
        tree_ = BallTree(std::move(balls));
}

void DecidedDiagram::validate_diagram() const {
    if (scene_.objects.empty())
        throw InputError(Kind::MissingKey, InputError::no_object, "objects", "are none: there is no cell");
    if (std::ranges::all_of(scene_.objects, is_vessel))
        throw InputError(Kind::MissingKey, InputError::no_object, "objects",
                         "are vessels alone: there is no cell");
    Scene as_scene;  // none of the objects is its base: what is wrong with one is told by its number
    as_scene.objects = scene_.objects;
    as_scene.names = scene_.names;
    as_scene.box = scene_.box;
    as_scene.tolerance = scene_.tolerance;
    validate(as_scene);
    const auto& tilt = scene_.tilt;
    const bool leans = tilt[0] != 0 || tilt[1] != 0 || tilt[2] != 0;
    if (leans && !(scene_.periodic[0] && scene_.periodic[1] && scene_.periodic[2]))
        throw InputError(Kind::Unsupported, InputError::no_object, "tilt",
                         "is of a box that repeats along all axes");
    for (const double t : tilt)
        if (!std::isfinite(t))
            throw InputError(Kind::NotFinite, InputError::no_object, "tilt", "must be finite");
    if (scene_.probe && !(*scene_.probe > 0 && std::isfinite(*scene_.probe)))
        throw InputError(Kind::OutOfRange, InputError::no_object, "probe", "must be positive");
    if (!scene_.is_periodic() && !scene_.probe) return;
    for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
        if (!is_ball(i))
            throw InputError(Kind::Unsupported, i, object_path(as_scene, i),
                             std::string("is no ball, and ") +
                                 (scene_.is_periodic() ? "in a box that repeats" : "with a probe") +
                                 " all objects are balls");
}

// Coordinates become multiples of one power of two, few enough digits that sums of several edges are exact.
void DecidedDiagram::snap() {
    constexpr int digits = 44;
    double size = std::max(scene_.box.min.cwiseAbs().maxCoeff(), scene_.box.max.cwiseAbs().maxCoeff());
    for (const Object& o : scene_.objects)
        size = std::max(size, std::get<Sphere>(o).center.cwiseAbs().maxCoeff());
    for (const double t : scene_.tilt) size = std::max(size, std::abs(t));
    const double grid = std::ldexp(1.0, std::ilogb(size) + 1 - digits);
    const auto round = [&](double& x) {
        const double to = std::nearbyint(x / grid) * grid;
        moved_ = std::max(moved_, std::abs(x - to));
        x = to;
    };
    for (Object& o : scene_.objects)
        for (double& x : std::get<Sphere>(o).center) round(x);
    for (int k = 0; k < 3; ++k) {
        if (!scene_.periodic[k]) continue;
        round(scene_.box.min[k]);
        round(scene_.box.max[k]);
    }
    for (double& t : scene_.tilt) round(t);
    moved_ *= std::sqrt(3.0) * (1 + std::numeric_limits<double>::epsilon());
}

Vec3 DecidedDiagram::shift(const Image& image) const {
    if (image == here) return Vec3::Zero();
    return edges_ * Vec3(image[0], image[1], image[2]);
}

Box DecidedDiagram::room(std::uint32_t i) const {
    if (!scene_.is_periodic()) return scene_.box;
    // Along an axis that repeats by itself the ball's own images leave it half an edge on both sides, and in
    // a box that leans half of all edges together; a quarter more, for the sides to be out of sight.
    constexpr double part = 0.625;
    const bool leans = scene_.tilt[0] != 0 || scene_.tilt[1] != 0 || scene_.tilt[2] != 0;
    const double all = part * edges_.colwise().norm().sum();
    const Vec3& c = ball(i).center;
    Box room = scene_.box;
    for (int k = 0; k < 3; ++k) {
        if (!scene_.periodic[k]) continue;
        const double space = leans ? all : part * edges_(k, k);
        room.min[k] = c[k] - space;
        room.max[k] = c[k] + space;
    }
    return room;
}

// A ball in another one, touching it from within included, is nowhere nearer; nor is one of several equal
// balls, which go to the first.
void DecidedDiagram::find_hidden() {
    std::vector<Ball> around;
    std::vector<std::pair<std::uint32_t, Image>> numbers;
    for (const BallTree::Entry& self : tree_.entries()) {
        const Sphere& s = self.ball;
        if (has_vessels_) {
            const auto vessel = std::ranges::find_if(
                others_, [&](std::uint32_t x) { return is_beyond_wall(scene_.objects[x], s); });
            if (vessel != others_.end()) {
                hidden_[self.number] = "lies beyond the wall of object " + std::to_string(*vessel);
                continue;
            }
        }
        around.assign(1, {s.center.x(), s.center.y(), s.center.z(), s.radius});
        numbers.assign(1, {self.number, here});
        // What holds the ball has it a radius deep.
        const double deep = -s.radius + 0x1p-40 * (s.radius + s.center.cwiseAbs().sum());
        within(s.center, deep, self.number,
               [&](const Sphere& ball, std::uint32_t number, const Image& image) {
                   if (ball.radius < s.radius) return;
                   around.push_back({ball.center.x(), ball.center.y(), ball.center.z(), ball.radius});
                   numbers.emplace_back(number, image);
               });
        if (around.size() == 1) continue;
        const BallNesting nesting = ball_nesting(around);
        if (const std::uint32_t in = nesting.enclosing[0]; in != UINT32_MAX) {
            hidden_[self.number] = "lies in object " + std::to_string(numbers[in].first);
            continue;
        }
        std::pair<std::uint32_t, Image> first = numbers[0];
        for (std::size_t k = 1; k < around.size(); ++k)
            if (nesting.first_equal[k] == 0) first = std::min(first, numbers[k]);
        if (first != numbers[0]) hidden_[self.number] = "equals object " + std::to_string(first.first);
    }
}

bool DecidedDiagram::may_touch(std::uint32_t x, std::uint32_t i, double reach) const {
    if (!is_ball(i)) return true;
    if (!is_ball(x)) return least_distance(scene_.objects[x], ball(i)) < reach;
    bool may = false;
    for_images(ball(i).center, ball(i).radius + reach, [&](const Image& image) {
        const Sphere moved{ball(x).center + shift(image), ball(x).radius};
        may = may || least_distance(moved, ball(i)) < reach;
    });
    return may;
}

// ---- One cell ---------------------------------------------------------------------------------------

namespace {

struct Candidate {
    const Object* other;  // none: the ball
    Sphere ball;
    std::uint32_t number;
    Image image;

    auto key() const { return std::tie(number, image); }
};

class CellFinder {
public:
    CellFinder(const DecidedDiagram& decided, std::uint32_t object) : decided_(decided), object_(object) {
        result_.min_clearance = result_.max_clearance = std::numeric_limits<double>::quiet_NaN();
    }

    DiagramCell operator()(std::optional<Cell>* kept) {
        using State = DiagramCell::State;
        const auto end = [&](State state, const std::string& reason) {
            result_.state = state;
            result_.reason = reason;
            result_.contacts.clear();
        };
        if (decided_.is_wall(object_)) {
            end(State::Wall, "has no cell: the others leave what is nearest to walls");
            return std::move(result_);
        }
        if (const std::string& hidden = decided_.hidden(object_); !hidden.empty()) {
            end(State::Empty, hidden);
            return std::move(result_);
        }
        try {
            const DiagramScene& all = decided_.scene();
            if (all.is_periodic() ||
                (decided_.is_ball(object_) && holds(all.box, decided_.ball(object_).center)))
                find_ball_cell(kept);
            else if (all.probe)
                find_beyond_box();
            else
                find_measures();
        } catch (const UndecidedError& e) {
            end(State::Undecided, e.what());
        } catch (const InternalError& e) {
            end(State::Undecided, std::string("internal error: ") + e.what());
        } catch (const InputError& e) {
            // Where the box repeats, a ball beyond a side that does not may still own some of it.
            const bool owns_nothing = e.kind == Kind::EmptyBox && !decided_.scene().is_periodic();
            end(owns_nothing ? State::Empty : State::Refused, e.what());
        }
        return std::move(result_);
    }

private:
    // ---- Balls ----

    void find_ball_cell(std::optional<Cell>* kept) {
        const Sphere& base = decided_.ball(object_);
        const Box room = decided_.room(object_);
        CellBound bound = bound_by_nearest(base, room);
        gather(bound);
        // On the surface of a packing the nearest balls leave much of the room to a cell: what was found then
        // bounds it better.
        constexpr std::size_t crowd = 192;
        if (candidates_.size() > crowd) {
            for (const Candidate& c : candidates_)
                if (c.other == nullptr) bound.add(c.ball);
            bound.settle(width_);
            gather(bound);
        }
        CellOptions options;
        options.probe = decided_.scene().probe;
        options.patches = kept != nullptr && !options.probe;
        Cell cell = voronoi_cell(part_scene(base, room), options);
        const Measures& m = cell.measures;
        result_.reach =
            2 * (m.max_clearance + m.max_clearance_error) * (1 + 4 * std::numeric_limits<double>::epsilon());
        result_.volume = m.volume;
        result_.volume_error = m.volume_error;
        result_.area = m.area;
        result_.area_error = m.area_error;
        result_.min_clearance = m.min_clearance;
        result_.max_clearance = m.max_clearance;
        result_.is_estimated = m.is_estimated;
        result_.candidates = static_cast<std::uint32_t>(candidates_.size());
        result_.assumed = cell.report.decisions.assumed;
        add_contacts(cell);
        if (kept) *kept = std::move(cell);
    }

    // The nearest balls bound the cell, most of the time nearly as well as all of them.
    CellBound bound_by_nearest(const Sphere& base, const Box& room) {
        constexpr std::size_t first_candidates = 28;
        // Balls of sectors are narrowed to this part of where the last of them is.
        constexpr double narrow = 0.375;
        CellBound bound(base);
        bound.add(room);
        if (const auto& probe = decided_.scene().probe) bound.add_cap(*probe);
        double last = 0;
        if (!decided_.scene().is_periodic()) {
            std::vector<std::pair<double, std::uint32_t>> nearest;
            decided_.tree().nearest(base.center, first_candidates + 1, nearest);
            for (const auto& [distance, place] : nearest) {
                const BallTree::Entry& e = decided_.tree().entries()[place];
                if (e.number != object_) bound.add(e.ball);
                last = std::max(last, distance);
            }
        } else {
            std::vector<std::pair<double, Sphere>> found;
            find_nearest(base, room, first_candidates, found);
            for (const auto& [distance, ball] : found) {
                bound.add(ball);
                last = std::max(last, distance);
            }
        }
        width_ = narrow * last;
        bound.settle(width_);
        return bound;
    }

    // Ever larger reaches find the nearest images: the tree holds the box alone.
    void find_nearest(const Sphere& base, const Box& room, std::size_t count,
                      std::vector<std::pair<double, Sphere>>& found) const {
        const double volume = decided_.scene().edges().determinant(),
                     balls = static_cast<double>(decided_.tree().entries().size());
        for (double reach = std::cbrt(volume * static_cast<double>(count) / balls);; reach *= 1.5) {
            found.clear();
            decided_.within(base.center, reach, object_,
                            [&](const Sphere& ball, std::uint32_t, const Image&) {
                                found.emplace_back((ball.center - base.center).norm() - ball.radius, ball);
                            });
            if (found.size() >= count || reach > 2 * (room.max - room.min).norm()) break;
        }
        const std::size_t kept = std::min(found.size(), count);
        std::ranges::partial_sort(found, found.begin() + static_cast<std::ptrdiff_t>(kept), {},
                                  &std::pair<double, Sphere>::first);
        found.resize(kept);
    }

    // All that may touch the cell.
    void gather(const CellBound& bound) {
        candidates_.clear();
        decided_.touching(bound, object_, [&](const Sphere& ball, std::uint32_t number, const Image& image) {
            candidates_.push_back({nullptr, ball, number, image});
        });
        for (const std::uint32_t x : decided_.others()) {
            const Object& other = decided_.scene().objects[x];
            if (bound.may_be_touched_by([&](const Vec3& p) { return least_distance(other, Sphere{p, 0}); }))
                candidates_.push_back({&other, {}, x, here});
        }
        std::ranges::sort(candidates_,
                          [](const Candidate& a, const Candidate& b) { return a.key() < b.key(); });
    }

    Scene part_scene(const Object& base, const Box& box) const {
        const DiagramScene& all = decided_.scene();
        Scene scene;
        scene.base = base;
        if (object_ < all.names.size()) scene.base_name = all.names[object_];
        scene.box = box;
        scene.units = all.units;
        scene.tolerance = all.tolerance;
        scene.objects.reserve(candidates_.size());
        for (const Candidate& c : candidates_) {
            scene.objects.push_back(c.other != nullptr ? *c.other : Object(c.ball));
            // Images have no numbers of their own.
            if (!all.is_periodic()) scene.numbers.push_back(c.number);
        }
        if (!all.names.empty())
            for (const Candidate& c : candidates_) scene.names.push_back(all.names[c.number]);
        return scene;
    }

    void add_contacts(const Cell& cell) {
        std::map<std::pair<Site, Image>, CellContact> found;
        const auto add = [&](const Site& site, const CellFace& face) {
            std::pair<Site, Image> key{site, here};
            if (site.is_object() && cell.scene.numbers.empty()) {
                const Candidate& c = candidates_[site.index];
                key = {Site::object(c.number), c.image};
            }
            CellContact& contact = found.try_emplace(key, CellContact{key.first, key.second}).first->second;
            ++contact.faces;
            contact.area += face.area;
            contact.area_error += face.area_error + std::numeric_limits<double>::epsilon() * contact.area;
            result_.touches_box = result_.touches_box || !site.is_object();
        };
        for (const CellFace& face : cell.faces) {
            if (face.site.kind == Site::Kind::Cap) {
                result_.exposed_area += face.area;
                result_.exposed_error +=
                    face.area_error + std::numeric_limits<double>::epsilon() * result_.exposed_area;
                continue;
            }
            add(face.site, face);
            for (const Site& site : face.extra_sites) add(site, face);
        }
        result_.contacts.reserve(found.size());
        for (const auto& [key, contact] : found) result_.contacts.push_back(contact);
    }

    // The cell of a ball that is centred outside the box, with a probe: nothing, where the box is beyond its
    // cap.
    void find_beyond_box() {
        const Sphere& self = decided_.ball(object_);
        const Box& box = decided_.scene().box;
        const Vec3 nearest = self.center.cwiseMax(box.min).cwiseMin(box.max);
        if (least_distance(Sphere{nearest, 0}, self) < *decided_.scene().probe)
            throw InputError(Kind::Unsupported, object_, "objects[" + std::to_string(object_) + "]",
                             "is centred outside the box, and reaches into it within the probe");
        throw InputError(Kind::EmptyBox, object_, "box", "is out of reach within the probe");
    }

    // ---- All others ----

    // Their cells may stand over base points outside the box, and have measures only.
    void find_measures() {
        const DiagramScene& all = decided_.scene();
        candidates_.clear();
        for (std::uint32_t x = 0; x < all.objects.size(); ++x) {
            if (x == object_ || !decided_.hidden(x).empty()) continue;
            candidates_.push_back({&all.objects[x], {}, x, here});
        }
        const Object& self = all.objects[object_];
        std::vector<Object> bases{self};
        if (const auto* plane = std::get_if<Plane>(&self))
            bases.push_back(Plane{plane->point, -plane->normal});
        std::map<std::uint32_t, CellContact> found;
        for (const Object& base : bases) {
            const CompleteMeasures m = complete_measures(part_scene(base, all.box));
            result_.volume += m.volume;
            result_.volume_error += m.volume_error;
            result_.area += m.area;
            result_.area_error += m.area_error;
            result_.is_estimated = result_.is_estimated || m.is_estimated;
            result_.assumed += m.assumed;
            for (const CompleteMeasures::Neighbor& n : m.neighbors) {
                CellContact& contact =
                    found.try_emplace(n.object, CellContact{Site::object(n.object)}).first->second;
                contact.area += n.area;
                contact.area_error += n.area_error;
            }
        }
        result_.touches_box = true;  // of planes and tubes always; of others not known
        result_.reach = std::numeric_limits<double>::infinity();
        result_.candidates = static_cast<std::uint32_t>(candidates_.size());
        for (const auto& [number, contact] : found) result_.contacts.push_back(contact);
    }

    const DecidedDiagram& decided_;
    const std::uint32_t object_;
    std::vector<Candidate> candidates_;
    double width_ = 0;  // of the parts of directions that bound a cell
    DiagramCell result_;
};

}  // namespace

DiagramCell find_cell(const DecidedDiagram& decided, std::uint32_t object, std::optional<Cell>* cell) {
    return CellFinder(decided, object)(cell);
}

}  // namespace vcell::whole
