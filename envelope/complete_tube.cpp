#include "complete_tube.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "../core/errors.hpp"
#include "../primitives/bases/cylinder_base.hpp"
#include "axis_parts.hpp"
#include "base_diagram.hpp"
#include "lift/complete_lift.hpp"
#include "measures/measures.hpp"

namespace vcell {

namespace {

class Assembly {
public:
    Assembly(const DecidedScene& decided, const Cylinder& base, bool with_measures)
        : scene_(decided.scene),
          base_(base),
          unit_(decided.unit),
          with_measures_(with_measures),
          diagonal_(scene_.box.diagonal()),
          tolerance_(scene_.fit_tolerance()),
          frame_(cylinder_frame(scene_, base_)),
          sides_(canonical_box(scene_.box, frame_)),
          axis_(scene_, base_, scene_.box, frame_) {
        // A part of the needles beside what holds the base.
        constexpr double of_needle = 0x1p-10;
        if (axis_.are_any_held())
            tolerance_ = std::min(tolerance_, of_needle * AxisParts::beside_needle * diagonal_);
    }

    // Does it come in parts, as another object holds what is about the axis, or crosses it?
    bool is_cut() const { return axis_.are_any_held() || axis_.are_any_crossed(); }

    CompleteTube operator()() {
        for (const std::array<double, 2>& part : axis_.parts()) add(part);
        if (with_measures_) finish_measures();
        rank_neighbors();
        return std::move(result_);
    }

private:
    // Farther from the planes at its ends what is assumed next to them may not have to be: nothing is taken
    // for granted unless it is in all stretches that keep clear of them.
    void add(const std::array<double, 2>& part) {
        bool is_assumed = false;
        const auto add_stretch = [&](bool takes_assumptions) {
            left_out_ += axis_.on_clear_stretch(part, [&](const auto& beyond, const auto& stretch) {
                add_part(beyond, stretch, [&](const MinimizationDiagram& d) {
                    if (takes_assumptions || d.assumptions.empty()) return;
                    is_assumed = true;
                    throw UndecidedError("objects are taken to meet in one point");
                });
            });
        };
        try {
            add_stretch(false);
        } catch (const UndecidedError&) {
            if (!is_assumed) throw;
            add_stretch(true);
        }
    }

    template <class Accept>
    void add_part(const std::array<bool, 6>& beyond, const std::array<double, 2>& stretch, Accept&& accept) {
        require_room(stretch);
        CylinderPart part{scene_.box, stretch, {}};
        for (std::size_t s = 0; s < beyond.size(); ++s)
            if (beyond[s]) part.sides[s] = CylinderPart::Wall::Beyond;
        const RadialBaseProblem problem = cylinder_base_problem(scene_, base_, unit_, &part);
        EnvelopeOptions options;
        options.floor = problem.floor;
        MinimizationDiagram above = diagram_of(problem, options);
        accept(above);
        if (problem.floor.empty()) {
            LiftedCell lifted = lift_all_around(problem, above, tolerance_, with_measures_);
            forget_ends(lifted.cell);
            require_known_vertices(lifted.cell);
            append(std::move(lifted), stretch, problem, {&above});
            return;
        }
        options.is_below_floor = true;
        MinimizationDiagram below = diagram_of(problem, options);
        accept(below);
        const auto shows_none = [&](const MinimizationDiagram& d) {
            return std::ranges::none_of(
                d.face_forms, [&](FormId f) { return f.valid() && problem.shows(f, d.is_below_floor); });
        };
        if (shows_none(above) && shows_none(below)) {
            result_.lifted.cell.parts.push_back({ends_of(stretch), 0});
            return;
        }
        LiftedCell lifted = lift_complete_part(problem, above, below, tolerance_, with_measures_);
        require_known_vertices(lifted.cell);
        append(std::move(lifted), stretch, problem, {&above, &below});
    }

    // On which side of a side's plane the axis is is told by doubles.
    void require_room(const std::array<double, 2>& stretch) const {
        constexpr double certain = 0x1p-40;
        for (const BoxSide& side : sides_)
            for (const double y : stretch)
                if (!AxisParts::is_across(side) && !(std::abs(side.k - side.m.y() * y) > certain * diagonal_))
                    throw UndecidedError("the base's axis runs along side " +
                                         to_string(Site::box_side(side.index)) +
                                         " of the box, too near to it");
    }

    // Next to a plane's, where heights grow without bound, a place of the chart that is known well enough to
    // tell what meets there may be next to nothing known of in space.
    void require_known_vertices(const Cell& part) const {
        for (const CellVertex& v : part.vertices)
            if (v.error > tolerance_)
                throw UndecidedError(
                    "a vertex next to an end of a part of the cell is not known within the "
                    "scene's tolerance");
    }

    // What RadialMeasurer tells of the body and of the ends of a stretch.
    static void forget_ends(Cell& cell) {
        Measures& m = cell.measures;
        m.body_volume = m.body_volume_error = m.base_area = m.base_area_error = 0;
        m.box_area = m.box_area_error = 0;
        for (const CellFace& f : cell.faces)
            if (!f.site.is_object()) {
                m.box_area += f.area;
                m.box_area_error += f.area_error + 0x1p-52 * f.area;
            }
    }

    std::array<Vec3, 2> ends_of(const std::array<double, 2>& stretch) const {
        return {frame_.to_world({0, stretch[0], 0}), frame_.to_world({0, stretch[1], 0})};
    }

    void append(LiftedCell part, const std::array<double, 2>& stretch, const RadialBaseProblem& problem,
                std::initializer_list<const MinimizationDiagram*> diagrams) {
        Cell& all = result_.lifted.cell;
        all.parts.push_back({ends_of(stretch), static_cast<std::uint32_t>(part.cell.faces.size())});
        const auto vertices = static_cast<std::uint32_t>(all.vertices.size()),
                   edges = static_cast<std::uint32_t>(all.edges.size()), seams = seams_;
        for (CellVertex& v : part.cell.vertices) all.vertices.push_back(std::move(v));
        for (CellEdge& e : part.cell.edges) {
            for (std::uint32_t& v : e.vertices) v += vertices;
            all.edges.push_back(std::move(e));
        }
        for (const EdgeId e : part.positions.ids()) result_.lifted.positions.push_back(part.positions[e]);
        for (CellFace& f : part.cell.faces) {
            for (TrimmedPatch& patch : f.patches)
                for (auto& loop : patch.loops)
                    for (TrimCurve& trim : loop) {
                        if (trim.edge) *trim.edge += edges;
                        if (!trim.seam) continue;
                        *trim.seam += seams;
                        seams_ = std::max(seams_, *trim.seam + 1);
                    }
            all.faces.push_back(std::move(f));
        }
        if (with_measures_) add(part.cell.measures);
        Report& report = all.report;
        report.decisions += part.cell.report.decisions;
        report.warnings.insert(report.warnings.end(), part.cell.report.warnings.begin(),
                               part.cell.report.warnings.end());
        for (const MinimizationDiagram* d : diagrams) {
            result_.work += d->work;
            for (const Assumption& a : d->assumptions)
                report.warnings.push_back(message(a, "taken to meet in one point over", problem));
        }
        result_.moves = most(result_.moves, problem.moves);
        result_.unit_of_parameters = problem.chart.unit_of_coordinates(unit_);
        for (const std::string& warning : problem.warnings)
            if (std::ranges::find(result_.warnings, warning) == result_.warnings.end())
                result_.warnings.push_back(warning);
    }

    void add(const Measures& part) {
        Measures& m = measures_;
        m.volume += part.volume;
        m.volume_error += part.volume_error + 0x1p-50 * (m.volume + part.volume);
        m.area += part.area;
        m.area_error += part.area_error + 0x1p-50 * m.area;
        m.box_area += part.box_area;
        m.box_area_error += part.box_area_error + 0x1p-50 * m.box_area;
        m.is_estimated = m.is_estimated || part.is_estimated;
        m.extend_clearances(part);
    }

    // What is left out is no wider than slabs across the axis; faces that do not run along one have about its
    // circumference times its width there. Of the body and the base counts the stretch whose circles the box
    // holds.
    void finish_measures() {
        Measures& m = measures_;
        m.volume_error +=
            left_out_.width * 0.25 * std::numbers::pi * diagonal_ * diagonal_ + left_out_.volume;
        m.area_error += left_out_.width * std::numbers::pi * diagonal_ + left_out_.area;
        m.box_area_error += left_out_.width * sides_across() + left_out_.area;
        m.is_estimated = true;
        m.touches_box = true;
        m.body_volume = m.body_volume_error = m.base_area = m.base_area_error = 0;
        try {
            const RadialBaseProblem problem = cylinder_base_problem(base_alone(scene_), base_, unit_);
            const double length = problem.stretch[1] - problem.stretch[0], radius = base_.radius,
                         error = 0x1p-48 * (length + std::abs(problem.stretch[0]) + diagonal_);
            m.base_area = 2 * std::numbers::pi * radius * length;
            m.base_area_error = 2 * std::numbers::pi * radius * error;
            m.body_volume = std::numbers::pi * radius * radius * length;
            m.body_volume_error = std::numbers::pi * radius * radius * error;
        } catch (const InputError& e) {
            if (e.kind != InputError::Kind::EmptyBox) throw;
        }
        result_.lifted.cell.measures = m;
    }

    // What slabs across the axis have of the box's sides, for each length of their width.
    double sides_across() const {
        double sum = 0;
        for (const BoxSide& side : sides_)
            if (!AxisParts::is_across(side)) sum += diagonal_ / std::hypot(side.m.x(), side.m.z());
        return sum;
    }

    void rank_neighbors() {
        result_.lifted.cell.neighbors.clear();
        vcell::rank_neighbors(result_.lifted.cell);
    }

    static Measures zero() {
        Measures m;
        m.volume = m.volume_error = m.area = m.area_error = m.box_area = m.box_area_error = 0;
        return m;
    }

    const Scene& scene_;
    const Cylinder base_;
    const double unit_;
    const bool with_measures_;
    const double diagonal_;
    double tolerance_;  // of fits
    const BaseFrame frame_;
    const std::array<BoxSide, 6> sides_;
    const AxisParts axis_;
    CompleteTube result_;
    Measures measures_ = zero();
    std::uint32_t seams_ = 0;
    AxisParts::LeftOut left_out_;
};

}  // namespace

std::optional<CompleteTube> lift_complete_tube(const DecidedScene& decided, bool with_measures,
                                               bool is_asked) {
    const std::optional<Cylinder> base = base_tube(decided.scene);
    if (!base) return std::nullopt;
    Assembly assembly(decided, *base, with_measures);
    if (!assembly.is_cut() && !(is_asked && is_oblique(decided.scene, *base))) return std::nullopt;
    CompleteTube tube = assembly();
    if (tube.lifted.cell.faces.empty())
        throw InputError(InputError::Kind::EmptyBox, InputError::no_object, "box",
                         "contains nothing that is nearest to the base cylinder (base.cylinder)");
    return tube;
}

}  // namespace vcell
