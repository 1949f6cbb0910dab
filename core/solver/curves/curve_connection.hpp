/// The last step of solve_curves(): runs are joined to components from neighbourhood to neighbourhood, and
/// what was left undecided to clusters with the branches that end there.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "../newton/curve_newton.hpp"
#include "../roots/solver.hpp"
#include "curve_work.hpp"

namespace vcell::curve {

template <int N>
class Connection {
    using Work = CurveWork<N>;
    using Box = typename Work::Box;
    using Part = typename Work::Part;
    using Leaf = typename Work::Leaf;
    using Slice = typename Work::Slice;
    using Stop = typename Work::Stop;
    using Run = typename Work::Run;
    static constexpr int D = Work::D;
    static constexpr std::size_t none = Work::none;

public:
    explicit Connection(Work& work)
        : f_(work.f),
          options_(work.options),
          unit_(work.unit),
          parts_(work.parts),
          leaves_(work.leaves),
          slices_(work.slices),
          runs_(work.runs),
          undecided_(work.undecided) {}

    CurveSet<D> run() {
        for (std::size_t seed = 0; seed < runs_.size(); ++seed)
            if (runs_[seed].component == none && !known(runs_[seed])) trace(seed);
        result_.parts = parts_.size();
        gather_clusters();
        return std::move(result_);
    }

private:
    struct Passage {
        std::size_t run;
        Box enter, leave;  // points of the curve, along the orientation
    };

    // --- Components

    Box point(std::size_t leaf, const Slice& s, double t) const { return point_of(f_, leaves_[leaf], s, t); }

    const Slice& slice_at(const Run& run, double t) const {
        std::size_t s = run.first;
        while (s + 1 < run.last && slices_[s].end < t) ++s;
        return slices_[s];
    }

    // All leaves whose neighbourhood contains the box.
    template <class Visit>
    void visit_leaves(const Box& p, Visit visit, std::size_t part = 0) const {
        const Part& node = parts_[part];
        if (!node.occupied || !is_subset(p, node.neighbourhoods)) return;
        if (node.leaf != none) visit(node.leaf);
        for (std::size_t c = node.first_child; c < node.first_child + node.children; ++c)
            visit_leaves(p, visit, c);
    }

    struct Successor {
        std::size_t run;
        Box point;
    };

    // The run on which the curve goes on after `run`, against the orientation when sense is -1. The point is
    // that at the end of the run. Sets `stop` where it does not go on.
    std::optional<Successor> successor(std::size_t run, int sense, Stop& stop) {
        const Run& from = runs_[run];
        const bool upwards = leaves_[from.leaf].direction * sense > 0;
        stop = upwards ? from.high : from.low;
        if (stop.kind != Stop::Open) return std::nullopt;
        const double t = upwards ? from.end : from.begin;
        const Box p = point(from.leaf, slice_at(from, t), t);
        // Injectivity: at its parameter, p is the only solution in the neighbourhood; so it lies on the run
        // that has the parameter. Of several runs, the one that leads furthest.
        std::optional<Successor> best;
        double furthest = 0;
        visit_leaves(p, [&](std::size_t l) {
            const Leaf& leaf = leaves_[l];
            const Interval& at = p[leaf.axis];
            for (std::size_t r = leaf.first_run; r < leaf.last_run; ++r) {
                if (!(runs_[r].begin <= at.lower() && at.upper() <= runs_[r].end)) continue;
                const double rest =
                    leaf.direction * sense > 0 ? runs_[r].end - at.upper() : at.lower() - runs_[r].begin;
                if (rest / unit_[leaf.axis] > furthest) {
                    furthest = rest / unit_[leaf.axis];
                    best = Successor{r, p};
                }
            }
        });
        if (best) return best;
        stop = {Stop::Undecided, undecided_.size(), p};
        for (std::size_t i = 0; i < undecided_.size(); ++i)
            if (overlap(undecided_[i], p)) {
                stop.index = i;
                return std::nullopt;
            }
        undecided_.push_back(p);
        return std::nullopt;
    }

    // Does the run's curve belong to a component found before? Asked at a point of it: curves of different
    // components have no point in common.
    bool known(const Run& run) const {
        for (const double fraction : {0.5, 0.3, 0.7}) {
            const double t = std::clamp(std::lerp(run.begin, run.end, fraction), run.begin, run.end);
            const Slice& s = slice_at(run, t);
            Box p = s.enclosure;
            p[leaves_[run.leaf].axis] = Interval(t);
            bool found = lies_on_component(p);
            if (!found) found = lies_on_component(point(run.leaf, s, t));
            if (found) return true;
        }
        return false;
    }
    bool lies_on_component(const Box& p) const {
        bool found = false;
        visit_leaves(p, [&](std::size_t l) {
            const Interval& at = p[leaves_[l].axis];
            for (std::size_t r = leaves_[l].first_run; !found && r < leaves_[l].last_run; ++r)
                found =
                    runs_[r].component != none && runs_[r].begin <= at.lower() && at.upper() <= runs_[r].end;
        });
        return found;
    }

    void trace(std::size_t seed) {
        const std::size_t id = result_.components.size();
        const auto end_box = [&](std::size_t run, int sense) {
            const Run& r = runs_[run];
            const bool upwards = leaves_[r.leaf].direction * sense > 0;
            const Stop& stop = upwards ? r.high : r.low;
            const double t = upwards ? r.end : r.begin;
            return stop.kind == Stop::Face ? stop.point : point(r.leaf, slice_at(r, t), t);
        };
        std::vector<Passage> passages{{seed, {}, {}}};
        runs_[seed].component = id;
        CurveComponent<D> component;
        std::array<Stop, 2> stops;
        while (const auto next = successor(passages.back().run, 1, stops[1])) {
            passages.back().leave = next->point;
            if (runs_[next->run].component == id) {
                // Back on a run of this walk, in the same sense: the curve is closed.
                component.closed = true;
                while (passages.front().run != next->run) passages.erase(passages.begin());
                passages.front().enter = next->point;
                break;
            }
            if (runs_[next->run].component != none) return;  // all of it is known
            runs_[next->run].component = id;
            passages.push_back({next->run, next->point, {}});
        }
        if (!component.closed) {
            passages.back().leave = end_box(passages.back().run, 1);
            while (const auto before = successor(passages.front().run, -1, stops[0])) {
                if (runs_[before->run].component == id) {
                    // A run met later in this walk begins before the present first one: the walk starts with
                    // it.
                    while (passages.front().run != before->run) passages.erase(passages.begin());
                    continue;
                }
                passages.front().enter = before->point;
                runs_[before->run].component = id;
                passages.insert(passages.begin(), {before->run, {}, before->point});
            }
            passages.front().enter = end_box(passages.front().run, -1);
        }
        for (const Passage& p : passages) emit(component, p);
        component.joints.push_back(passages.back().leave);
        if (!component.closed) {
            for (const int end : {0, 1}) {
                component.ends[end].index = stops[end].index;
                if (stops[end].kind == Stop::Undecided) component.ends[end].kind = CurveEnd::Kind::Cluster;
            }
        }
        result_.components.push_back(std::move(component));
    }

    void emit(CurveComponent<D>& component, const Passage& passage) const {
        const Run& run = runs_[passage.run];
        const Leaf& leaf = leaves_[run.leaf];
        const int k = leaf.axis;
        const bool upwards = leaf.direction > 0;
        const Interval in = upwards ? passage.enter[k] : passage.leave[k],
                       out = upwards ? passage.leave[k] : passage.enter[k];
        const double begin = std::clamp(in.lower(), run.begin, run.end),
                     end = std::clamp(out.upper(), run.begin, run.end);
        std::vector<Tube<D>> tubes;
        for (std::size_t s = run.first; s < run.last; ++s) {
            const Slice& slice = slices_[s];
            if (slice.end <= begin || slice.begin >= end) continue;
            Tube<D> tube{k, std::max(begin, slice.begin), std::min(end, slice.end), slice.enclosure,
                         leaf.neighbourhood};
            tube.enclosure[k] = tube.parameter();
            tubes.push_back(tube);
        }
        if (!upwards) {
            std::reverse(tubes.begin(), tubes.end());
            for (Tube<D>& t : tubes) std::swap(t.begin, t.end);
        }
        for (std::size_t i = 0; i < tubes.size(); ++i) {
            component.joints.push_back(
                i == 0 ? passage.enter : narrowed(f_, tubes[i].enclosure, k, Interval(tubes[i].begin)));
            component.tubes.push_back(tubes[i]);
        }
    }

    // --- Clusters

    // Around a singular point undecided boxes lie scattered, with proved arcs between them not much longer.
    // Boxes this near to each other, in units of the least width, are one cluster, and such arcs belong to
    // it.
    static constexpr double reach = 64;

    Box reached(const Box& box) const {
        Box wide;
        for (int i = 0; i < D; ++i) {
            const double r = reach * options_.min_width * unit_[i];
            wide[i] = Interval(box[i].lower() - r, box[i].upper() + r);
        }
        return wide;
    }

    void gather_clusters() {
        if (undecided_.empty()) return;
        std::vector<Box> wide;
        for (const Box& box : undecided_) wide.push_back(reached(box));
        std::vector<std::size_t> cluster_of(undecided_.size());
        for (const std::vector<std::size_t>& group : detail::clusters<D>(wide)) {
            CurveCluster<D> cluster{undecided_[group.front()], {}};
            for (const std::size_t i : group) {
                cluster_of[i] = result_.undecided.size();
                cluster.box = hull(cluster.box, undecided_[i]);
            }
            result_.undecided.push_back(std::move(cluster));
        }
        for (CurveComponent<D>& component : result_.components)
            for (CurveEnd& end : component.ends)
                if (end.kind == CurveEnd::Kind::Cluster) end.index = cluster_of[end.index];
        std::erase_if(result_.components, [&](const CurveComponent<D>& component) {
            const auto [a, b] = component.ends;
            if (component.closed || a.kind != CurveEnd::Kind::Cluster || b.kind != a.kind ||
                a.index != b.index)
                return false;
            Box all = component.tubes.front().enclosure;
            for (const Tube<D>& tube : component.tubes) all = hull(all, tube.enclosure);
            Box& box = result_.undecided[a.index].box;
            if (!is_subset(all, reached(box))) return false;
            box = hull(box, all);
            return true;
        });
        for (std::size_t id = 0; id < result_.components.size(); ++id)
            for (const std::size_t end : {0, 1})
                if (const CurveEnd& e = result_.components[id].ends[end];
                    !result_.components[id].closed && e.kind == CurveEnd::Kind::Cluster)
                    result_.undecided[e.index].branches.push_back({id, end});
    }

    const CurveSystem<N>& f_;
    const CurveOptions& options_;
    const std::array<double, D>& unit_;
    const std::vector<Part>& parts_;
    const std::vector<Leaf>& leaves_;
    const std::vector<Slice>& slices_;
    std::vector<Run>& runs_;
    std::vector<Box>& undecided_;
    CurveSet<D> result_;
};

}  // namespace vcell::curve
