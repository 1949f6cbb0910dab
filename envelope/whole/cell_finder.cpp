#include "cell_finder.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "../../core/errors.hpp"
#include "../complete_measures.hpp"
#include "../object_distance.hpp"
#include "../voronoi_cell.hpp"
#include "ball_cell.hpp"
#include "complete_cells.hpp"

namespace vcell::whole {

namespace {

using Kind = InputError::Kind;

std::vector<BallTree::Entry> balls_of(const DiagramScene& scene) {
    std::vector<BallTree::Entry> balls;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (const auto* ball = std::get_if<Sphere>(&scene.objects[i])) balls.push_back({*ball, i});
    return balls;
}

}  // namespace

// ---- The scene --------------------------------------------------------------------------------------

void validate_diagram(const DiagramScene& scene) {
    if (scene.objects.empty())
        throw InputError(Kind::MissingKey, InputError::no_object, "objects", "are none: there is no cell");
    if (std::ranges::all_of(scene.objects, is_vessel))
        throw InputError(Kind::MissingKey, InputError::no_object, "objects",
                         "are vessels alone: there is no cell");
    Scene as_scene;  // none of the objects is its base: what is wrong with one is told by its number
    as_scene.objects = scene.objects;
    as_scene.names = scene.names;
    as_scene.box = scene.box;
    as_scene.tolerance = scene.tolerance;
    as_scene.probe = scene.probe;
    validate(as_scene);
    const auto& tilt = scene.tilt;
    const bool leans = tilt[0] != 0 || tilt[1] != 0 || tilt[2] != 0;
    if (leans && !(scene.periodic[0] && scene.periodic[1] && scene.periodic[2]))
        throw InputError(Kind::Unsupported, InputError::no_object, "tilt",
                         "is of a box that repeats along all axes");
    for (const double t : tilt)
        if (!std::isfinite(t))
            throw InputError(Kind::NotFinite, InputError::no_object, "tilt", "must be finite");
    if (!scene.is_periodic()) return;
    const Lattice lattice(scene);
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (const auto* ball = std::get_if<Sphere>(&object)) {
            if (!lattice.has_image_at(ball->center))
                throw InputError(Kind::OutOfRange, i, object_path(as_scene, i, "center"),
                                 "is too many edges away from the box that repeats");
            continue;
        }
        if (own_periods(lattice, object)) continue;
        if (std::holds_alternative<Cylinder>(object))
            throw InputError(
                Kind::Unsupported, i, object_path(as_scene, i, "axis"),
                "is along no whole combination of edges of the box that repeats, at most 16 of each: the tube "
                "does not close on itself");
        throw InputError(Kind::Unsupported, i, object_path(as_scene, i),
                         "is not where it was after an edge along which the box repeats");
    }
}

double snap_to_grid(DiagramScene& scene) {
    if (!scene.is_periodic()) return 0;
    const Lattice given(scene);
    double moved = 0;
    constexpr int digits = 44;
    double size = std::max(scene.box.min.cwiseAbs().maxCoeff(), scene.box.max.cwiseAbs().maxCoeff());
    for (Object& o : scene.objects) size = std::max(size, place_of(o).cwiseAbs().maxCoeff());
    for (const double t : scene.tilt) size = std::max(size, std::abs(t));
    const double grid = std::ldexp(1.0, std::ilogb(size) + 1 - digits);
    const auto round = [&](double& x) {
        const double to = std::nearbyint(x / grid) * grid;
        moved = std::max(moved, std::abs(x - to));
        x = to;
    };
    for (Object& o : scene.objects)
        for (double& x : place_of(o)) round(x);
    std::vector<std::vector<Image>> periods;
    for (const Object& o : scene.objects)
        periods.push_back(std::holds_alternative<Sphere>(o) ? std::vector<Image>() : *own_periods(given, o));
    for (int k = 0; k < 3; ++k) {
        if (!scene.periodic[k]) continue;
        round(scene.box.min[k]);
        round(scene.box.max[k]);
    }
    for (double& t : scene.tilt) round(t);
    moved *= std::sqrt(3.0);
    const Lattice lattice(scene);
    double turned = 0;
    for (std::size_t i = 0; i < periods.size(); ++i)
        turned = std::max(turned, align(lattice, periods[i], scene.objects[i]));
    return (moved + turned) * (1 + std::numeric_limits<double>::epsilon());
}

DecidedDiagram::DecidedDiagram(const DiagramScene& scene) {
    validate_diagram(scene);
    part_.scene = scene;
    part_.moved = snap_to_grid(part_.scene);
    part_.hidden = find_hidden(part_.scene, {}, ImageTree(Lattice(part_.scene), balls_of(part_.scene)));
    index();
    part_.balls = balls_.tree().entries().size();
}

DecidedDiagram::DecidedDiagram(ScenePart part) : part_(std::move(part)) {
    hide_others(part_.scene, Lattice(part_.scene), part_.numbers, part_.hidden);
    index();
}

void DecidedDiagram::index() {
    lattice_ = Lattice(part_.scene);
    for (std::uint32_t i = 0; i < part_.scene.objects.size(); ++i)
        if (!is_ball(i) && part_.hidden[i].empty())
            others_.push_back({i, OtherImages(lattice_, part_.scene.objects[i])});
    std::vector<BallTree::Entry> balls = balls_of(part_.scene);
    std::erase_if(balls, [&](const BallTree::Entry& e) { return !part_.hidden[e.number].empty(); });
    balls_ = ImageTree(lattice_, std::move(balls));
}

Box DecidedDiagram::room(const Sphere& ball) const {
    if (!scene().is_periodic()) return scene().box;
    // Along an axis that repeats by itself the ball's own images leave it half an edge on both sides, and in
    // a box that leans half of all edges together; a quarter more, for the sides to be out of sight.
    constexpr double part = 0.625;
    const bool leans = scene().tilt[0] != 0 || scene().tilt[1] != 0 || scene().tilt[2] != 0;
    const Eigen::Matrix3d& edges = lattice_.edges();
    const double all = part * edges.colwise().norm().sum();
    const Vec3& c = ball.center;
    Box room = scene().box;
    for (int k = 0; k < 3; ++k) {
        if (!scene().periodic[k]) continue;
        const double space = leans ? all : part * edges(k, k);
        room.min[k] = c[k] - space;
        room.max[k] = c[k] + space;
    }
    return room;
}

std::span<const Image> DecidedDiagram::periods(std::uint32_t i) const {
    const auto other = std::ranges::lower_bound(others_, i, {}, &Other::place);
    if (other == others_.end() || other->place != i) return {};
    return other->images.periods();
}

std::vector<ObjectImage> DecidedDiagram::all_periods() const {
    std::vector<ObjectImage> all;
    for (const Other& other : others_)
        for (const Image& period : other.images.periods()) all.push_back({number(other.place), period});
    return all;
}

Image DecidedDiagram::image_beside(std::uint32_t i, const ObjectImage& other) const {
    if (others_.empty()) return other.image;
    std::vector<Image> both(periods(i).begin(), periods(i).end());
    const std::span<const Image> of_other = periods(place(other.number));
    both.insert(both.end(), of_other.begin(), of_other.end());
    return representative(other.image, both);
}

bool DecidedDiagram::is_bounded(std::uint32_t i) const {
    return is_ball(i) && (scene().is_periodic() || holds(scene().box, ball(i).center));
}

DecidedDiagram::Competitors DecidedDiagram::competitors(const Sphere& ball, std::uint32_t self,
                                                        std::size_t count) const {
    const Vec3& center = ball.center;
    Competitors found;
    if (!lattice_.repeats()) {
        found.nearest = balls_.nearest(center, 0, count, self);
        found.reach = found.nearest.size() < count ? std::numeric_limits<double>::infinity()
                                                   : found.nearest.back().distance;
        return found;
    }
    // Ever larger reaches find the nearest images: the tree holds the box alone.
    const Box room = this->room(ball);
    const double volume = scene().edges().determinant(), balls = static_cast<double>(part_.balls);
    found.reach = std::cbrt(volume * static_cast<double>(count) / balls);
    while (true) {
        found.nearest = balls_.nearest(center, found.reach, count, self);
        if (found.nearest.size() == count || found.reach > 2 * (room.max - room.min).norm()) return found;
        found.reach *= 1.5;
    }
}

DecidedDiagram::Bound DecidedDiagram::bound(const Sphere& base,
                                            std::span<const ImageTree::Found> nearest) const {
    CellBound bound(base);
    bound.add(room(base));
    if (scene().probe) bound.add_cap(*scene().probe);
    for (const ImageTree::Found& f : nearest) bound.add(f.ball);
    const double last =
        nearest.empty() ? 0 : std::max(0.0, nearest[std::min(nearest.size(), few) - 1].distance);
    Bound result{std::move(bound), last};
    result.bound.settle(result.width());
    return result;
}

DecidedDiagram::Bound DecidedDiagram::bound(std::uint32_t i) const {
    Bound of_few = bound(ball(i), competitors(i, few).nearest);
    return of_few.is_poor() ? bound(ball(i), competitors(i, many).nearest) : of_few;
}

bool DecidedDiagram::may_touch(std::uint32_t x, std::uint32_t i, double reach) const {
    // The cell of a ball beyond the box has no reach that is known.
    if (!is_ball(i) || reach == infinity) return true;
    bool may = false;
    const Sphere& self = ball(i);
    if (!is_ball(x)) {
        OtherImages(lattice_, scene().objects[x])
            .near(self.center, self.radius + reach, [&](const Object& other, const Image&) {
                may = may || least_distance(other, self) < reach;
            });
        return may;
    }
    lattice_.for_images(Box{ball(x).center, ball(x).center}, ball(x).radius, self.center, self.radius + reach,
                        [&](const Image&, const Vec3& by) {
                            const Sphere moved{ball(x).center + by, ball(x).radius};
                            may = may || least_distance(moved, self) < reach;
                        });
    return may;
}

// ---- One cell ---------------------------------------------------------------------------------------

namespace {

struct Candidate {
    Object object;
    std::uint32_t place;
    Image image;

    auto key() const { return std::tie(place, image); }
};

class CellFinder {
public:
    CellFinder(const DecidedDiagram& decided, std::uint32_t object, const Neighborhood* around,
               SharedParts* shared)
        : decided_(decided), object_(object), around_(around), shared_(shared) {
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
            if (decided_.is_bounded(object_))
                find_ball_cell(kept);
            else
                find_measures(kept);
        } catch (const UndecidedError& e) {
            end(State::Undecided, e.what());
        } catch (const InternalError& e) {
            end(State::Undecided, std::string("internal error: ") + e.what());
        } catch (const InputError& e) {
            end(e.kind == Kind::EmptyBox ? State::Empty : State::Refused, e.what());
        }
        return std::move(result_);
    }

private:
    // ---- Balls ----

    void find_ball_cell(std::optional<Cell>* kept) {
        const Sphere& base = decided_.ball(object_);
        const Box room = decided_.room(base);
        if (!holds(room, base.center)) return find_cell_beyond(base, room);
        if (decided_.is_simple() && kept == nullptr)
            if (auto found = measured_ball_cell(decided_, object_, room, around_, shared_ != nullptr)) {
                result_ = std::move(found->cell);
                if (shared_ != nullptr) *shared_ = std::move(found->shared);
                return;
            }
        DecidedDiagram::Bound by_nearest = decided_.bound(object_);
        CellBound& bound = by_nearest.bound;
        gather(bound);
        // On the surface of a packing the nearest balls leave much of the room to a cell: what was found then
        // bounds it better.
        constexpr std::size_t crowd = 192;
        if (candidates_.size() > crowd) {
            for (const Candidate& c : candidates_)
                if (const auto* ball = std::get_if<Sphere>(&c.object)) bound.add(*ball);
            bound.settle(by_nearest.width());
            std::erase_if(candidates_, [&](const Candidate& c) { return !may_touch(bound, c.object); });
        }
        CellOptions options;
        options.patches = kept != nullptr;
        Cell cell = voronoi_cell(part_scene(base, room), options);
        take(cell);
        if (kept) *kept = std::move(cell);
    }

    // The cell of a ball that is centred on a side of a box that repeats along others, or beyond it.
    void find_cell_beyond(const Sphere& base, const Box& room) {
        require_within_reach(base, room);
        cover_box();
        gather(decided_.bound(object_).bound);
        Found found;
        measure(part_scene(base, room), found);
        keep(found);
    }

    void take(const Cell& cell) {
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
    }

    // All that may touch the cell.
    void gather(const CellBound& bound) {
        candidates_.clear();
        decided_.balls().touching(bound, [&](const Sphere& ball, std::uint32_t place, const Image& image) {
            if (place != object_ || image != here) candidates_.push_back({ball, place, image});
        });
        for (const DecidedDiagram::Other& other : decided_.others())
            other.images.near(bound.base().center, reach_of(bound, other.images.object()),
                              [&](const Object& moved, const Image& image) {
                                  if (may_touch(bound, moved))
                                      candidates_.push_back({moved, other.place, image});
                              });
        std::ranges::sort(candidates_,
                          [](const Candidate& a, const Candidate& b) { return a.key() < b.key(); });
    }
    // How far a tube, made of balls of its radius, is at most from the centre if it touches the bound.
    static double reach_of(const CellBound& bound, const Object& other) {
        const auto* tube = std::get_if<Cylinder>(&other);
        return tube == nullptr ? infinity : bound.extent(tube->radius);
    }
    static bool may_touch(const CellBound& bound, const Object& other) {
        if (const auto* ball = std::get_if<Sphere>(&other)) return bound.may_touch(*ball);
        return bound.may_be_touched_by([&](const Vec3& p) { return least_distance(other, Sphere{p, 0}); });
    }

    Scene part_scene(const Object& base, const Box& box) const {
        const DiagramScene& all = decided_.scene();
        Scene scene = scene_without_others(decided_, object_);
        scene.base = base;
        scene.box = box;
        scene.objects.reserve(candidates_.size());
        for (const Candidate& c : candidates_) {
            scene.objects.push_back(c.object);
            if (all.is_periodic())
                scene.images.push_back({decided_.number(c.place), c.image});
            else
                scene.numbers.push_back(decided_.number(c.place));
        }
        if (!all.names.empty())
            for (const Candidate& c : candidates_) scene.names.push_back(all.names[c.place]);
        return scene;
    }

    using Found = std::map<std::pair<Site, Image>, CellContact>;
    CellContact& contact_in(Found& found, const Scene& scene, const Site& site) const {
        std::pair<Site, Image> key{site, here};
        if (site.is_object() && !scene.images.empty()) {
            const ObjectImage& other = scene.images[site.index];
            key = {Site::object(other.number), decided_.image_beside(object_, other)};
        }
        return found.try_emplace(key, CellContact{key.first, key.second}).first->second;
    }
    void keep(const Found& found) {
        result_.contacts.reserve(found.size());
        for (const auto& [key, contact] : found) result_.contacts.push_back(contact);
    }

    void add_contacts(const Cell& cell) {
        Found found;
        const auto add = [&](const Site& site, const CellFace& face) {
            CellContact& contact = contact_in(found, cell.scene, site);
            ++contact.faces;
            contact.area += face.area;
            contact.area_error += face.area_error + std::numeric_limits<double>::epsilon() * contact.area;
            result_.touches_box = result_.touches_box || !site.is_object();
        };
        for (const CellFace& face : cell.faces) {
            if (add_exposed(face)) continue;
            add(face.site, face);
            for (const Site& site : face.extra_sites) add(site, face);
        }
        keep(found);
    }

    // Is it the cap's?
    bool add_exposed(const CellFace& face) {
        if (face.site.kind != Site::Kind::Cap) return false;
        result_.exposed_area += face.area;
        result_.exposed_error +=
            face.area_error + std::numeric_limits<double>::epsilon() * result_.exposed_area;
        return true;
    }

    // A ball that is centred outside the box may end at a probe before that.
    void require_within_reach(const Sphere& ball, const Box& box) const {
        const auto& probe = decided_.scene().probe;
        const Vec3 nearest = ball.center.cwiseMax(box.min).cwiseMin(box.max);
        if (probe && !(least_distance(Sphere{nearest, 0}, ball) < *probe))
            throw InputError(Kind::EmptyBox, decided_.number(object_), "box",
                             "is out of reach within the probe");
    }

    // ---- All others ----

    // Their cells may stand over base points outside the box, and have measures only; a tube's complete cell
    // is measured where it is asked for, so that it is computed once.
    void find_measures(std::optional<Cell>* kept) {
        cover_box();
        if (decided_.is_ball(object_)) require_within_reach(decided_.ball(object_), decided_.scene().box);
        if (kept != nullptr && std::holds_alternative<Cylinder>(decided_.scene().objects[object_])) {
            std::vector<Cell> cells = complete_cells(decided_, object_);
            if (cells.size() == 1) {
                take_complete(cells.front());
                *kept = std::move(cells.front());
                return;
            }
        }
        Found found;
        for (const Scene& scene : scenes_among_all(decided_, object_)) measure(scene, found);
        keep(found);
    }
    void measure(const Scene& scene, Found& found) {
        const CompleteMeasures m = complete_measures(scene);
        result_.candidates = static_cast<std::uint32_t>(scene.objects.size());
        result_.volume += m.volume;
        result_.volume_error += m.volume_error;
        result_.area += m.area;
        result_.area_error += m.area_error;
        result_.exposed_area += m.exposed_area;
        result_.exposed_error += m.exposed_error;
        result_.is_estimated = result_.is_estimated || m.is_estimated;
        result_.assumed += m.assumed;
        for (const CompleteMeasures::Neighbor& n : m.neighbors) {
            CellContact& contact = contact_in(found, scene, Site::object(n.object));
            contact.area += n.area;
            contact.area_error += n.area_error;
        }
    }
    void cover_box() {
        result_.touches_box = true;  // of planes and tubes always; of others not known
        result_.reach = std::numeric_limits<double>::infinity();
    }
    void take_complete(const Cell& cell) {
        const Measures& m = cell.measures;
        result_.volume = m.volume;
        result_.volume_error = m.volume_error;
        result_.area = m.area;
        result_.area_error = m.area_error;
        result_.is_estimated = m.is_estimated;
        result_.candidates = static_cast<std::uint32_t>(cell.scene.objects.size());
        result_.assumed = cell.report.decisions.assumed;
        Found found;
        double of_faces = 0;
        for (const CellFace& face : cell.faces) {
            const auto add = [&](const Site& site) {
                if (!site.is_object()) return;
                CellContact& contact = contact_in(found, cell.scene, site);
                contact.area += face.area;
                contact.area_error += face.area_error + std::numeric_limits<double>::epsilon() * contact.area;
            };
            add_exposed(face);
            add(face.site);
            for (const Site& site : face.extra_sites) add(site);
            if (face.site.is_object()) of_faces += face.area_error;
        }
        // Slabs that are in no part of the cell may have faces with any of them, too.
        const double left_out = std::max(0.0, m.area_error - of_faces);
        for (auto& [key, contact] : found) contact.area_error += left_out;
        keep(found);
    }

    const DecidedDiagram& decided_;
    const std::uint32_t object_;
    const Neighborhood* const around_;  // none: that of the object alone
    SharedParts* const shared_;         // none: the cell is to be complete by itself
    std::vector<Candidate> candidates_;
    DiagramCell result_;
};

}  // namespace

DiagramCell find_cell(const DecidedDiagram& decided, std::uint32_t object, std::optional<Cell>* cell) {
    return CellFinder(decided, object, nullptr, nullptr)(cell);
}

FoundCell find_sharing_cell(const DecidedDiagram& decided, std::uint32_t object, const Neighborhood& around) {
    FoundCell found;
    found.cell = CellFinder(decided, object, &around, &found.shared)(nullptr);
    return found;
}

}  // namespace vcell::whole
