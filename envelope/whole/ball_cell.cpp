#include "ball_cell.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../../primitives/bases/sphere_base.hpp"
#include "../measures/arc_measures.hpp"
#include "../sphere/sphere_diagram.hpp"
#include "cell_marks.hpp"

namespace vcell::whole {

namespace {

using Neighbor = ImageTree::Found;

// Balls that are inserted before others are looked for; and others of a time, after which fewer of those that
// are left may touch the cell.
constexpr std::size_t first_balls = 20, more_balls = 24;
// Where the cell among the first has faces of which marks tell nothing.
constexpr std::size_t many_balls = 60;

void add_area(DiagramCell& cell, const CellContact& contact) {
    cell.area += contact.area;
    cell.area_error += contact.area_error + std::numeric_limits<double>::epsilon() * cell.area;
}

Image opposite(const Image& image) {
    return {static_cast<std::int16_t>(-image[0]), static_cast<std::int16_t>(-image[1]),
            static_cast<std::int16_t>(-image[2])};
}

Image moved_by(const Image& by, const Image& image) {
    return {static_cast<std::int16_t>(image[0] + by[0]), static_cast<std::int16_t>(image[1] + by[1]),
            static_cast<std::int16_t>(image[2] + by[2])};
}

// What it inserts, and in which order, is a matter of the cell alone: the nearest balls first, and then what
// may touch it in one shell about them after the other. The neighbourhood is where some of them are at hand.
class BallCellFinder {
public:
    BallCellFinder(const DecidedDiagram& decided, std::uint32_t object, const Box& room,
                   std::vector<BallSearch>* searches)
        : decided_(decided), object_(object), room_(room), base_(decided.ball(object)), searches_(searches) {}

    // The cell is known to touch these, and nothing else.
    void begin(std::span<const CellContact> contacts) {
        searched_ = infinity;
        for (const CellContact& contact : contacts) {
            if (!contact.site.is_object()) continue;
            const std::uint32_t place = decided_.place(contact.site.index);
            const Sphere& ball = decided_.ball(place);
            const Sphere moved{ball.center + decided_.balls().lattice().shift(contact.image), ball.radius};
            candidates_.push_back({distance_of(moved), place, contact.image, moved});
        }
        set_unit();
    }
    // False where that is too few.
    bool begin(const Neighborhood& around) {
        at_hand_ = around.reach();
        around_.clear();
        around_.reserve(around.balls().size());
        const Image home = around.is_in_box() ? decided_.balls().home(object_) : Image{0, 0, 0};
        const Vec3 by = decided_.balls().lattice().shift(home);
        for (const Neighbor& n : around.balls()) {
            const Sphere ball{n.ball.center + by, n.ball.radius};
            const Image image = moved_by(home, n.image);
            const double distance = distance_of(ball);
            if (distance > at_hand_ || (n.number == object_ && image == Image{0, 0, 0})) continue;
            around_.push_back({distance, n.number, image, ball});
        }
        if (around_.size() < first_balls && at_hand_ < infinity) return false;
        const auto end = nearest_first(around_, first_balls);
        candidates_.reserve(first_balls + more_balls);
        candidates_.assign(around_.begin(), end);
        around_.erase(around_.begin(), end);
        // As near as the last one there may be more.
        searched_ = candidates_.empty() ? infinity : std::nextafter(candidates_.back().distance, -infinity);
        set_unit();
        return true;
    }

    std::optional<FoundCell> operator()(bool is_sharing) {
        Scene scene;
        const auto base = scaled(base_);
        const auto low = scaled(Sphere{room_.min, 0}), high = scaled(Sphere{room_.max, 0});
        if (!base || !low || !high) return std::nullopt;
        scene.base = *base;
        scene.box = {low->center, high->center};
        scene.objects.reserve(candidates_.size());
        for (const Neighbor& n : candidates_) {
            const auto ball = scaled(n.ball);
            if (!ball) return std::nullopt;
            scene.objects.emplace_back(*ball);
        }
        problem_.emplace(scene, unit_);
        const RadialBaseProblem& problem = problem_->problem();
        if (problem.moves.all != 0 || !problem.warnings.empty()) return std::nullopt;
        DiscArcs arcs;
        if (!disc_arcs_on_sphere(
                problem.family, [this](const auto& marks) { return more(marks); },
                {[this](FormId form, const auto& tied, Sign value) {
                     return problem_->tie_sign(form, tied, value);
                 },
                 [this](const auto& forms) { return problem_->tie_along(forms); }},
                arcs))
            return std::nullopt;
        return measured(arcs, is_sharing);
    }

private:
    // So many come to the beginning, ascending; where others begin.
    static std::vector<Neighbor>::iterator nearest_first(std::vector<Neighbor>& balls, std::size_t count) {
        const auto end = balls.begin() + static_cast<std::ptrdiff_t>(std::min(count, balls.size()));
        const auto is_nearer = [](const Neighbor& a, const Neighbor& b) { return a.key() < b.key(); };
        std::ranges::nth_element(balls, end, is_nearer);
        std::sort(balls.begin(), end, is_nearer);
        return end;
    }
    // In a unit of the cell's size heights are no steeper than directions tell.
    void set_unit() {
        step_ = candidates_.empty() ? (room_.max - room_.min).maxCoeff() : 0;
        for (const Neighbor& n : candidates_) step_ = std::max(step_, 0.5 * (n.distance + n.ball.radius));
        unit_ = std::ldexp(1.0, std::ilogb(step_));
    }
    // None where that is not exact, or out of all proportion.
    std::optional<Sphere> scaled(const Sphere& ball) const {
        constexpr double most = 0x1p200;
        const double factor = 1 / unit_;
        const Sphere s{factor * ball.center, factor * ball.radius};
        const bool is_exact = unit_ * s.center == ball.center && unit_ * s.radius == ball.radius;
        if (!is_exact || !(s.center.cwiseAbs().maxCoeff() < most && s.radius < most)) return std::nullopt;
        return s;
    }

    double distance_of(const Sphere& ball) const { return (ball.center - base_.center).norm() - ball.radius; }

    // Balls that the marks leave and that are not among the forms, some at a time, in shells that get wider.
    // A cell gets small soon, and what is far from it is not looked at one by one.
    MoreForms more(const std::function<SphereMarks()>& known) {
        // What may not touch a cell may not touch what others leave of it.
        if (waiting_.empty() && searched_ >= reach_) return MoreForms::None;
        const SphereMarks places = known();
        CellMarks marks(base_, places, marks_turn(), unit_);
        if (!marks.are_bounds()) return is_widened_ ? MoreForms::GivenUp : widen();
        reach_ = marks.reach();
        marks.look_between(-infinity, reach_);
        std::erase_if(waiting_, [&](const Neighbor& n) { return !marks.may_touch(n.ball); });
        while (waiting_.empty()) {
            if (searched_ >= reach_) return MoreForms::None;
            const double to = std::min(searched_ + step_, reach_);
            if (searches_ != nullptr)
                searches_->push_back({searched_, to, PlacedMarks{places, marks_turn(), unit_}});
            marks.look_between(searched_, to);
            take_at_hand(to, [&](const Sphere& ball) { return marks.may_touch(ball); });
            if (to > at_hand_) {
                marks.look_between(std::max(searched_, at_hand_), to);
                decided_.balls().touching(
                    marks, [&](const Sphere& ball, std::uint32_t number, const Image& image) {
                        if (number != object_ || image != Image{0, 0, 0})
                            waiting_.push_back({distance_of(ball), number, image, ball});
                    });
            }
            searched_ = to;
            step_ *= 2;
        }
        add_nearest(more_balls);
        return is_out_of_range_ ? MoreForms::GivenUp : MoreForms::Added;
    }
    // The cell among a few balls may have faces of which marks tell nothing: all of the next shell come.
    MoreForms widen() {
        is_widened_ = true;
        const double to = searched_ + step_;
        if (searches_ != nullptr) searches_->push_back({searched_, to, std::nullopt});
        take_at_hand(to, [](const Sphere&) { return true; });
        const double from = std::max(searched_, at_hand_);
        if (to > from)
            decided_.balls().within(base_.center, to,
                                    [&](const Sphere& ball, std::uint32_t number, const Image& image) {
                                        const double distance = distance_of(ball);
                                        if (distance > from && distance <= to)
                                            waiting_.push_back({distance, number, image, ball});
                                    });
        searched_ = to;
        add_nearest(many_balls);
        return is_out_of_range_ ? MoreForms::GivenUp : MoreForms::Added;
    }
    const Eigen::Matrix3d& marks_turn() const { return problem_->problem().chart.turn; }
    // Those of the neighbourhood that are in the shell.
    void take_at_hand(double to, auto&& may_touch) {
        std::erase_if(around_, [&](const Neighbor& n) {
            if (n.distance > to) return false;
            if (may_touch(n.ball)) waiting_.push_back(n);
            return true;
        });
    }
    void add_nearest(std::size_t count) {
        const auto end = nearest_first(waiting_, count);
        for (auto n = waiting_.begin(); n != end && !is_out_of_range_; ++n) is_out_of_range_ = !add(*n);
        waiting_.erase(waiting_.begin(), end);
    }
    bool add(const Neighbor& n) {
        const auto ball = scaled(n.ball);
        const Site site = Site::object(static_cast<std::uint32_t>(candidates_.size()));
        if (!ball || !problem_->add(*ball, site)) return false;
        candidates_.push_back(n);
        return true;
    }

    std::optional<FoundCell> measured(const DiscArcs& arcs, bool is_sharing) const {
        const RadialBaseProblem& problem = problem_->problem();
        // A contact for each face, and the face's place.
        std::vector<std::pair<CellContact, std::uint32_t>> contacts;
        contacts.reserve(arcs.faces.size());
        std::vector<char> is_asked(arcs.faces.size(), 1);
        for (std::uint32_t i = 0; i < arcs.faces.size(); ++i) {
            const std::span<const Site> sites = problem.sites[arcs.faces[i]];
            if (sites.size() != 1) return std::nullopt;
            CellContact contact{sites.front()};
            if (contact.site.is_object()) {
                const Neighbor& n = candidates_[contact.site.index];
                contact.site = Site::object(decided_.number(n.number));
                contact.image = n.image;
                is_asked[i] = !is_sharing || n.number >= object_ ? 1 : 0;
            }
            contact.faces = is_asked[i] != 0 ? 1 : 0;
            contacts.emplace_back(contact, i);
        }
        ArcMeasures measures;
        if (!measure_arcs(problem, arcs, is_asked, measures)) return std::nullopt;
        std::ranges::sort(contacts, {}, [](const auto& c) { return std::pair(c.first.site, c.first.image); });

        FoundCell found;
        found.shared.is_sharing = is_sharing;
        DiagramCell& cell = found.cell;
        const double square = unit_ * unit_, cube = square * unit_;
        constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();
        cell.contacts.reserve(contacts.size());
        for (auto& [contact, i] : contacts) {
            if (is_asked[i] != 0) {
                const FaceMeasures& face = measures.faces[i];
                // A face thinner than the spacing of doubles may come out below zero by its rounding.
                contact.area = square * std::max(0.0, face.area.value);
                contact.area_error = square * face.area.error + rounding * contact.area;
                const double volume = cube * face.volume.value,
                             error = cube * face.volume.error + rounding * std::abs(volume);
                cell.volume += volume;
                cell.volume_error += error;
                if (contact.site.is_object()) add_area(cell, contact);
                if (is_sharing && contact.site.is_object() && contact.site.index > decided_.number(object_)) {
                    const double both = cube * face.both.value;
                    found.shared.parts.push_back(
                        {both - volume, cube * face.both.error + error + rounding * std::abs(both)});
                }
            }
            cell.touches_box = cell.touches_box || !contact.site.is_object();
            cell.contacts.push_back(contact);
        }
        cell.volume_error += rounding * std::abs(cell.volume);
        const double radius = base_.radius, most = unit_ * measures.most,
                     most_error = unit_ * measures.most_error + rounding * (most + radius);
        cell.min_clearance = unit_ * measures.least - radius;
        cell.max_clearance = most - radius;
        cell.reach = 2 * (cell.max_clearance + most_error) * (1 + rounding);
        cell.candidates = static_cast<std::uint32_t>(candidates_.size());
        if (!is_finite(found)) return std::nullopt;
        return found;
    }

    static bool is_finite(const FoundCell& found) {
        const DiagramCell& c = found.cell;
        return std::isfinite(c.volume + c.volume_error + c.area + c.area_error + c.min_clearance + c.reach) &&
               std::ranges::all_of(found.shared.parts,
                                   [](const auto& p) { return std::isfinite(p.volume + p.error); });
    }

    const DecidedDiagram& decided_;
    const std::uint32_t object_;
    const Box& room_;
    const Sphere base_;
    double unit_ = 1;
    std::vector<Neighbor> candidates_;
    std::optional<GrowingSphereProblem> problem_;
    // That may touch the cell, and are not among the forms.
    std::vector<Neighbor> waiting_;
    // All balls whose surfaces are no farther than that from the base's centre, but for those that have been
    // asked about.
    std::vector<Neighbor> around_;
    double at_hand_ = -infinity;
    std::vector<BallSearch>* const searches_;  // none: nobody asks
    bool is_widened_ = false, is_out_of_range_ = false;
    // No ball touches the cell whose surface is this far from the base's centre, or farther.
    double reach_ = infinity;
    // All balls whose surfaces are no farther than that from there have been asked about, and how much
    // farther it goes from there.
    double searched_ = -infinity, step_ = 0;
};

}  // namespace

std::optional<FoundCell> measured_ball_cell(const DecidedDiagram& decided, std::uint32_t object,
                                            const Box& room, const Neighborhood* around, bool is_sharing,
                                            std::vector<BallSearch>* searches) {
    BallCellFinder finder(decided, object, room, searches);
    if ((around == nullptr || !finder.begin(*around)) && !finder.begin(Neighborhood(decided, object)))
        return std::nullopt;
    return finder(is_sharing);
}

std::optional<FoundCell> common_ball_cell(const DecidedDiagram& decided, std::uint32_t object,
                                          std::vector<BallSearch>& searches) {
    if (!decided.is_simple() || !decided.hidden(object).empty() || !decided.is_bounded(object))
        return std::nullopt;
    const Box room = decided.room(decided.ball(object));
    if (!holds(room, decided.ball(object).center)) return std::nullopt;
    try {
        return measured_ball_cell(decided, object, room, nullptr, true, &searches);
    } catch (const UndecidedError&) {
    } catch (const InternalError&) {
    } catch (const InputError&) {
    }
    return std::nullopt;
}

bool complete_ball_cell(const DecidedDiagram& decided, std::uint32_t object, DiagramCell& cell) {
    const Box room = decided.room(decided.ball(object));
    BallCellFinder finder(decided, object, room, nullptr);
    finder.begin(cell.contacts);
    auto found = finder(false);
    if (!found || found->cell.contacts.size() != cell.contacts.size()) return false;
    // What has been shared stays what both cells have.
    DiagramCell& complete = found->cell;
    complete.area = complete.area_error = 0;
    for (std::size_t k = 0; k < cell.contacts.size(); ++k) {
        CellContact& contact = complete.contacts[k];
        const CellContact& known = cell.contacts[k];
        if (contact.site != known.site || contact.image != known.image) return false;
        if (known.faces != 0) contact = known;
        if (contact.site.is_object()) add_area(complete, contact);
    }
    complete.candidates = cell.candidates;
    cell = std::move(complete);
    return true;
}

void add_given_faces(std::uint32_t giver, const DiagramCell& cell, const SharedParts& shared,
                     std::vector<GivenFace>& faces) {
    if (!shared.is_sharing) return;
    auto part = shared.parts.begin();
    for (const CellContact& contact : cell.contacts)
        if (contact.site.is_object() && contact.site.index > giver)
            faces.push_back({giver, contact, *part++});
}

void take(const GivenFace& given, DiagramCell& cell) {
    const std::pair key(Site::object(given.giver), opposite(given.contact.image));
    const auto place = std::ranges::lower_bound(
        cell.contacts, key, {}, [](const CellContact& c) { return std::pair(c.site, c.image); });
    if (place == cell.contacts.end() || std::pair(place->site, place->image) != key || place->faces != 0)
        return;
    place->faces = given.contact.faces;
    place->area = given.contact.area;
    place->area_error = given.contact.area_error;
    cell.volume += given.part.volume;
    cell.volume_error += given.part.error + std::numeric_limits<double>::epsilon() * std::abs(cell.volume);
    add_area(cell, *place);
}

bool lacks_faces(const DiagramCell& cell) {
    return std::ranges::any_of(cell.contacts, [](const CellContact& c) { return c.faces == 0; });
}

std::vector<std::uint32_t> share_faces(std::span<DiagramCell> cells, std::span<const SharedParts> parts) {
    std::vector<GivenFace> faces;
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
        faces.clear();
        add_given_faces(i, cells[i], parts[i], faces);
        for (const GivenFace& face : faces)
            if (const std::uint32_t to = face.contact.site.index; parts[to].is_sharing) take(face, cells[to]);
    }
    std::vector<std::uint32_t> lacking;
    for (std::uint32_t i = 0; i < cells.size(); ++i)
        if (parts[i].is_sharing && lacks_faces(cells[i])) lacking.push_back(i);
    return lacking;
}

}  // namespace vcell::whole
