#include "curve.hpp"

#include <algorithm>
#include <cassert>
#include <map>
#include <optional>

#include "../newton/curve_newton.hpp"
#include "../roots/solver.hpp"

namespace vcell {

namespace {

using namespace curve;

// Boxes and slices are cut off the middle, so that curves of symmetric systems do not run along the cuts.
constexpr double cut = 0.47;
// The neighbourhood of a part reaches beyond it by this fraction of its widest side. It decides how far
// neighbours overlap, that is, how fine the slices near a part's sides become, and nothing else.
constexpr double margin = 0.0625;

double length(const Interval& i) { return i.upper() - i.lower(); }

template <int N>
class Solver {
    static constexpr int D = N + 1;
    using Box = IntervalBox<D>;

    // A regular part.
    struct Leaf {
        Box part;           // contracted: holds all solutions of its part of the domain
        Box neighbourhood;  // f is injective in it for every value of the axis
        int axis;
        int direction;  // of the axis along the orientation of the curve: 1 or -1
        std::size_t first_run = 0, last_run = 0;
    };
    struct Part {
        Box box;
        Box neighbourhoods;  // hull of those of the leaves below
        std::size_t first_child = 0;
        int children = 0;
        std::size_t leaf = none;
        bool occupied = false;  // has it leaves below?
    };
    // One solution for every parameter.
    struct Slice {
        double begin, end;
        Box enclosure;
    };
    // Where a run stops.
    struct Stop {
        enum Kind { Open, Face, Undecided } kind = Open;
        std::size_t index = 0;  // of the face or the undecided box
        Box point = {};         // of a face
    };
    // Adjoining slices of a leaf, upwards.
    struct Run {
        std::size_t leaf;
        std::size_t first, last;  // slices [first, last)
        double begin, end;
        Stop low, high;
        std::size_t component = none;
    };
    struct Piece {
        std::size_t run;
        Box enter, leave;  // points of the curve, along the orientation
    };
    static constexpr std::size_t none = SIZE_MAX;

public:
    Solver(const CurveSystem<N>& f, const Box& domain, const CurveOptions& options)
        : f_(f), domain_(domain), options_(options) {
        for (int i = 0; i < D; ++i) {
            unit_[i] = length(domain[i]);
            assert(unit_[i] > 0 && std::isfinite(unit_[i]));
        }
    }

    CurveSet<D> solve() {
        subdivide();
        for (std::size_t i = 0; i < leaves_.size(); ++i) slice(i);
        connect();
        result_.parts = parts_.size();
        gather_clusters();
        return std::move(result_);
    }

private:
    // ---- Subdivision

    void subdivide() {
        parts_.push_back({domain_, domain_});
        for (std::size_t i = 0; i < parts_.size(); ++i) examine(i);
        for (std::size_t i = parts_.size(); i-- > 0;) {
            Part& p = parts_[i];
            if (p.leaf != none) {
                p.neighbourhoods = leaves_[p.leaf].neighbourhood;
                p.occupied = true;
            }
            for (std::size_t c = p.first_child; c < p.first_child + p.children; ++c) {
                if (!parts_[c].occupied) continue;
                p.neighbourhoods =
                    p.occupied ? hull(p.neighbourhoods, parts_[c].neighbourhoods) : parts_[c].neighbourhoods;
                p.occupied = true;
            }
        }
    }

    Box neighbourhood(const Box& part) const {
        double widest = 0;
        for (int i = 0; i < D; ++i) widest = std::max(widest, length(part[i]) / unit_[i]);
        Box u;
        for (int i = 0; i < D; ++i) {
            const double m = margin * widest * unit_[i];
            u[i] = Interval(Interval::down(part[i].lower() - m), Interval::up(part[i].upper() + m));
        }
        return u;
    }

    void examine(std::size_t index) {
        const Box whole = parts_[index].box;
        const Box u = neighbourhood(whole);
        const auto j = f_.differentiate(u);
        for (int e = 0; e < N; ++e)
            if (j[e].value.sign().value_or(Sign::Zero) != Sign::Zero) return;

        Box part = whole;
        const Box c = centre(whole);
        const auto value = f_(c);
        if (!contract(part, c, value, j)) return;

        // The axis along which the curve runs, measured in units of the domain.
        const auto t = tangent<N>(j);
        int axis = 0;
        for (int k = 1; k < D; ++k)
            if (std::abs(t[k]) * unit_[axis] > std::abs(t[axis]) * unit_[k]) axis = k;
        if (t[axis] != 0 && std::isfinite(t[axis])) {
            const Preconditioned<N, Interval> p(j, axis);
            if (N > 1 && !contract(part, c, p.apply(value), p)) return;
            if (p.regular(unit_) && moderate(p)) {
                parts_[index].leaf = leaves_.size();
                leaves_.push_back({part, *intersection(u, neighbourhood(part)), axis, t[axis] > 0 ? 1 : -1});
                return;
            }
        }

        double widest = 0;
        int split = 0;
        double kept = 1;
        for (int i = 0; i < D; ++i) {
            const double w = length(part[i]) / unit_[i];
            if (w > widest) widest = w, split = i;
            if (length(whole[i]) > 0) kept *= length(part[i]) / length(whole[i]);
        }
        if (widest <= options_.min_width || parts_.size() >= options_.max_parts) {
            undecided_.push_back(part);
            return;
        }
        constexpr double worth_another_look = 0.3;
        parts_[index].first_child = parts_.size();
        if (kept < worth_another_look) {
            parts_[index].children = 1;
            parts_.push_back({part, part});
            return;
        }
        parts_[index].children = 2;
        const double at = part[split].lower() + cut * length(part[split]);
        Box low = part, high = part;
        low[split] = Interval(part[split].lower(), at);
        high[split] = Interval(at, part[split].upper());
        parts_.push_back({low, low});
        parts_.push_back({high, high});
    }

    // A part is left to its slices when the curve is nowhere steeper than this against the axis, measured in
    // units of the domain: smaller parts have a better axis.
    bool moderate(const Preconditioned<N, Interval>& p) const {
        constexpr double steepest = 10;
        const Box slope = p.slopes(unit_);
        for (int i = 0; i < D; ++i)
            if (!(slope[i].magnitude() * unit_[p.axis()] <= steepest * unit_[i])) return false;
        return true;
    }

    // Solves each row of value + jacobian (x - c) = 0 for each coordinate; false: no solution in the part.
    bool contract(Box& part, const Box& c, const std::array<Interval, N>& value, const auto& rows) const {
        for (int e = 0; e < N; ++e) {
            const auto& row = gradient(rows, e);
            std::array<Interval, D> terms;
            for (int l = 0; l < D; ++l) terms[l] = row[l] * (part[l] - c[l]);
            Interval sum = value[e];
            for (const Interval& t : terms) sum += t;
            if (sum.lower() > 0 || sum.upper() < 0) return false;
            for (int l = 0; l < D; ++l) {
                if (row[l].lower() <= 0 && row[l].upper() >= 0) continue;
                Interval rest = value[e];
                for (int o = 0; o < D; ++o)
                    if (o != l) rest += terms[o];
                const auto kept = intersection(part[l], c[l] - rest / row[l]);
                if (!kept) return false;
                part[l] = *kept;
                terms[l] = row[l] * (part[l] - c[l]);
            }
        }
        return true;
    }
    static const Box& gradient(const Jets<Interval, N>& j, int e) { return j[e].gradient; }
    static const Box& gradient(const Preconditioned<N, Interval>& p, int e) { return p.row(e); }

    // ---- Slices

    void slice(std::size_t index) {
        Leaf& leaf = leaves_[index];
        const int k = leaf.axis;
        // Beyond the part by half the margin, but not beyond the domain.
        const double reach = 0.5 * margin * length(leaf.part[k]);
        const Interval t(
            std::max({leaf.part[k].lower() - reach, domain_[k].lower(), leaf.neighbourhood[k].lower()}),
            std::min({leaf.part[k].upper() + reach, domain_[k].upper(), leaf.neighbourhood[k].upper()}));
        const std::size_t first = slices_.size();
        const Point<D> start = mid(leaf.part);
        prove(leaf, t, approximate(leaf, start, t.lower()), approximate(leaf, start, t.upper()));
        clip(leaf, first);
        leaf.first_run = runs_.size();
        for (std::size_t s = first; s < slices_.size(); ++s) append(index, s);
        leaf.last_run = runs_.size();
    }

    // The double approximation of the curve at a parameter, and whether it is near enough to the leaf's part
    // to be of interest and far enough from the neighbourhood's sides to be provable. Only a guide.
    struct Trial {
        Point<D> x;
        bool near;
    };
    Trial approximate(const Leaf& leaf, const Point<D>& start, double t) const {
        Trial trial{start, false};
        trial.x[leaf.axis] = t;
        // Newton that would leave the neighbourhood, perhaps for another branch, goes on from its boundary.
        for (int step = 0; step < 8 && !trial.near; ++step) {
            clamp_into(trial.x, leaf.neighbourhood);
            const Point<D> before = trial.x;
            trial.near = settle<N>(f_, trial.x, leaf.axis, tolerance(leaf), 1);
            Point<D> inside = trial.x;
            clamp_into(inside, leaf.neighbourhood);
            if (inside == before) break;
        }
        for (int i = 0; i < D; ++i)
            if (i != leaf.axis) {
                const Interval near = halfway(leaf, i);
                trial.near = trial.near && trial.x[i] > near.lower() && trial.x[i] < near.upper();
            }
        return trial;
    }
    static Interval halfway(const Leaf& leaf, int i) {
        const Interval &part = leaf.part[i], &u = leaf.neighbourhood[i];
        return {0.5 * (part.lower() + u.lower()), 0.5 * (part.upper() + u.upper())};
    }
    static double tolerance(const Leaf& leaf) { return 1e-2 * margin * width(leaf.part); }

    // A point between the two where the curve is still near and soon no more.
    Trial last_near(const Leaf& leaf, Trial in, Trial out) const {
        for (int i = 0; i < D; ++i) {
            const Interval near = halfway(leaf, i);
            if (i == leaf.axis || near.contains(out.x[i])) continue;
            Trial exit = in;
            exit.x[i] = out.x[i] < near.lower() ? near.lower() : near.upper();
            const auto [lo, hi] = std::minmax(in.x[leaf.axis], out.x[leaf.axis]);
            if (settle<N>(f_, exit.x, i, tolerance(leaf), 5) && lo < exit.x[leaf.axis] &&
                exit.x[leaf.axis] < hi)
                return exit;
        }
        for (int step = 0; step < 5; ++step) {
            const Trial middle = approximate(leaf, in.x, std::midpoint(in.x[leaf.axis], out.x[leaf.axis]));
            (middle.near ? in : out) = middle;
        }
        return in;
    }

    // Finds the slices of the leaf's curve with parameters in t, from `low` to `high`. What is left out is
    // proved not to meet the leaf's part.
    void prove(const Leaf& leaf, const Interval& t, const Trial& low, const Trial& high) {
        if (low.near != high.near) {
            // The curve comes or goes through a side: cut there, so that one piece is provable as a whole and
            // the other is as a whole away from the part.
            const Trial in = low.near ? last_near(leaf, low, high) : last_near(leaf, high, low);
            const double at = in.x[leaf.axis];
            if (t.lower() < at && at < t.upper()) {
                const Trial gone{in.x, false};
                divide(leaf, Interval(t.lower(), at), low, low.near ? in : gone);
                divide(leaf, Interval(at, t.upper()), low.near ? gone : in, high);
                return;
            }
        }
        divide(leaf, t, low, high);
    }

    void divide(const Leaf& leaf, const Interval& t, const Trial& low, const Trial& high) {
        if (!low.near && !high.near && away(leaf, t)) return;
        Point<D> guess;
        for (int i = 0; i < D; ++i) guess[i] = std::midpoint(low.x[i], high.x[i]);
        guess[leaf.axis] = t.lower() + cut * length(t);
        const Trial middle = approximate(leaf, guess, guess[leaf.axis]);
        const int near = low.near + middle.near + high.near;
        if (near > 0 && has_tube(leaf, t, {low.x, middle.x, high.x})) return;
        if (low.near != high.near && away(leaf, t)) return;
        if (length(t) <= options_.min_width * unit_[leaf.axis] || ++divided_slices_ > options_.max_parts) {
            Box rest = leaf.part;
            if (const auto common = intersection(rest[leaf.axis], t)) {
                rest[leaf.axis] = *common;
                undecided_.push_back(rest);
            }
            return;
        }
        prove(leaf, Interval(t.lower(), middle.x[leaf.axis]), low, middle);
        prove(leaf, Interval(middle.x[leaf.axis], t.upper()), middle, high);
    }

    // Proves that a curve passes near the three points, for all parameters in t; within the neighbourhood it
    // is the only one.
    bool has_tube(const Leaf& leaf, const Interval& t, const std::array<Point<D>, 3>& points) {
        // Room for the image to fit in: it is as wide as the slope varies, a few times the deviation from the
        // chord.
        constexpr double room = 0.125, deviations = 6, least_room = 0x1p-24;
        const auto& [low, middle, high] = points;
        const double where = (middle[leaf.axis] - low[leaf.axis]) / (high[leaf.axis] - low[leaf.axis]);
        Box y;
        for (int i = 0; i < D; ++i) {
            const double lo = std::min({low[i], middle[i], high[i]}),
                         hi = std::max({low[i], middle[i], high[i]});
            const double deviation = std::abs(middle[i] - std::lerp(low[i], high[i], where));
            const double r =
                room * (hi - lo) + deviations * deviation + least_room * length(leaf.neighbourhood[i]);
            const auto inside = intersection(Interval(lo - r, hi + r), leaf.neighbourhood[i]);
            if (!inside) return false;
            y[i] = *inside;
        }
        y[leaf.axis] = t;
        Point<D> m = middle;
        clamp_into(m, y);
        const Box at = converted<Interval>(m);
        const auto value = f_(at);
        for (int attempt = 0; attempt < 2; ++attempt) {
            const Preconditioned<N, Interval> p(f_.differentiate(y), leaf.axis);
            const Box image = p.newton(y, at, p.apply(value));
            if (strictly_inside(image, y, leaf.axis)) {
                keep(leaf, image);
                return true;
            }
            // The image says how much room it needs.
            for (int i = 0; i < D; ++i) {
                if (i == leaf.axis) continue;
                const double r = room * length(image[i]);
                const auto wider =
                    intersection(Interval(image[i].lower() - r, image[i].upper() + r), leaf.neighbourhood[i]);
                if (!wider || !wider->contains(m[i])) return false;
                y[i] = *wider;
            }
        }
        return false;
    }

    // Proves that the leaf's part holds no solution with a parameter in t.
    bool away(const Leaf& leaf, const Interval& t) const {
        Box rest = leaf.part;
        const auto common = intersection(rest[leaf.axis], t);
        if (!common) return true;
        rest[leaf.axis] = *common;
        for (;;) {
            const auto j = f_.differentiate(rest);
            const Box before = rest, c = centre(rest);
            const auto value = f_(c);
            if (!contract(rest, c, value, j)) return true;
            if constexpr (N > 1) {
                const Preconditioned<N, Interval> p(j, leaf.axis);
                if (!contract(rest, c, p.apply(value), p)) return true;
            }
            constexpr double worth_another_look = 0.8;
            bool narrower = false;
            for (int i = 0; i < D; ++i)
                narrower = narrower || length(rest[i]) < worth_another_look * length(before[i]);
            if (!narrower) return false;
        }
    }

    void keep(const Leaf& leaf, const Box& enclosure) {
        if (overlap(enclosure, domain_))
            slices_.push_back({enclosure[leaf.axis].lower(), enclosure[leaf.axis].upper(), enclosure});
    }

    // ---- The domain's faces

    struct Crossing {
        Interval t;
        int face;
        Box point;
    };

    // Cuts the slices from `first` on at the domain's faces.
    void clip(const Leaf& leaf, std::size_t first) {
        std::vector<Slice> uncut(slices_.begin() + first, slices_.end());
        slices_.resize(first);
        stops_.clear();
        for (const Slice& s : uncut) clip(leaf, s);
    }

    void clip(const Leaf& leaf, const Slice& s) {
        const int k = leaf.axis;
        if (!overlap(s.enclosure, domain_)) return;
        if (is_subset(s.enclosure, domain_)) {
            slices_.push_back(s);
            return;
        }
        if (s.end - s.begin <= options_.min_width * unit_[k]) {
            undecided_.push_back(*intersection(s.enclosure, domain_));
            stops_[{s.begin, false}] = stops_[{s.end, true}] = {Stop::Undecided, undecided_.size() - 1, {}};
            return;
        }
        // With all slopes across the faces of one sign, each face is crossed once at most, and the signs at
        // the ends tell whether it is.
        Box y = s.enclosure;
        const Preconditioned<N, Interval> p(f_.differentiate(y), k);
        std::optional<Crossing> low, high;
        bool clear = p.regular(unit_);
        if (clear) {
            const Box slope = p.slopes(unit_);
            const std::array ends{narrowed(f_, y, k, Interval(s.begin)), narrowed(f_, y, k, Interval(s.end))};
            for (int i = 0; clear && i < D; ++i) {
                if (i == k || is_subset(s.enclosure[i], domain_[i])) continue;
                const auto direction = slope[i].sign().value_or(Sign::Zero);
                if (direction == Sign::Zero) {
                    clear = false;
                    break;
                }
                for (int upper = 0; clear && upper < 2; ++upper) {
                    const double c = upper ? domain_[i].upper() : domain_[i].lower();
                    if (upper ? s.enclosure[i].upper() <= c : s.enclosure[i].lower() >= c) continue;
                    // Outwards distances at both ends.
                    const Interval a = upper ? ends[0][i] - Interval(c) : Interval(c) - ends[0][i];
                    const Interval b = upper ? ends[1][i] - Interval(c) : Interval(c) - ends[1][i];
                    const Sign sa = a.sign().value_or(Sign::Zero), sb = b.sign().value_or(Sign::Zero);
                    if (sa == Sign::Zero || sb == Sign::Zero) {
                        clear = false;
                    } else if (sa == Sign::Positive && sb == Sign::Positive) {
                        return;
                    } else if (sa != sb) {
                        const auto found = crossing(s, k, i, 2 * i + upper, c);
                        std::optional<Crossing>& side = sb == Sign::Positive ? high : low;
                        if (!found || (side && overlap(std::array{side->t}, std::array{found->t})))
                            clear = false;
                        else if (!side || (sb == Sign::Positive ? found->t.lower() < side->t.lower()
                                                                : found->t.upper() > side->t.upper()))
                            side = found;
                    }
                }
            }
            if (clear && low && high) {
                if (high->t.upper() < low->t.lower()) return;  // passes the domain's corner outside
                clear = low->t.upper() < high->t.lower();
            }
        }
        if (!clear) {
            const double split = s.begin + cut * (s.end - s.begin);
            for (const Interval& t : {Interval(s.begin, split), Interval(split, s.end)}) {
                Box half = y;
                half[k] = t;
                half = narrowed_once(half, k);
                clip(leaf, {t.lower(), t.upper(), half});
            }
            return;
        }
        Slice inside = s;
        if (low) {
            inside.begin = low->t.lower();
            stops_[{inside.begin, true}] = {Stop::Face, static_cast<std::size_t>(low->face), low->point};
        }
        if (high) {
            inside.end = high->t.upper();
            stops_[{inside.end, false}] = {Stop::Face, static_cast<std::size_t>(high->face), high->point};
        }
        inside.enclosure[k] = Interval(inside.begin, inside.end);
        slices_.push_back(inside);
    }

    Box narrowed_once(const Box& y, int k) const {
        Point<D> m = middle_at(y, k, y[k].mid());
        settle<N>(f_, m, k, 0.0, 2);
        clamp_into(m, y);
        const Box at = converted<Interval>(m);
        const Preconditioned<N, Interval> p(f_.differentiate(y), k);
        return intersection(p.newton(y, at, p.apply(f_(at))), y).value_or(y);
    }

    // The parameter at which the slice's curve meets x[i] = c, between points proved to lie on either side.
    // Pre: the signs of x[i] - c at the slice's ends differ, and x[i] is monotone.
    std::optional<Crossing> crossing(const Slice& s, int k, int i, int face, double c) const {
        double lo = s.begin, hi = s.end;
        const double sign_lo = narrowed(f_, s.enclosure, k, Interval(lo))[i].lower() > c ? 1 : -1;
        // Newton for x[i] = c along the other coordinates finds the place, certified points beside it prove
        // it.
        Point<D> guess = mid(s.enclosure);
        guess[i] = c;
        settle<N>(f_, guess, i, 0.0, 6);
        double step = 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(guess[k]), hi - lo);
        if (guess[k] > lo && guess[k] < hi) {
            for (int attempt = 0; attempt < 12; ++attempt, step *= 4) {
                bool found = true;
                for (const double t : {guess[k] - step, guess[k] + step}) {
                    if (!(t > lo && t < hi)) continue;
                    const Interval x = narrowed(f_, s.enclosure, k, Interval(t))[i];
                    const bool before = sign_lo > 0 ? x.lower() > c : x.upper() < c;
                    const bool after = sign_lo > 0 ? x.upper() < c : x.lower() > c;
                    if (before) lo = t;
                    if (after) hi = t;
                    found = found && (before || after);
                }
                if (found && hi - lo <= 4 * step) break;
            }
        }
        if (!(hi - lo <= options_.min_width * unit_[k])) return std::nullopt;
        Crossing result{Interval(lo, hi), face, narrowed(f_, s.enclosure, k, Interval(lo, hi))};
        result.point[i] = Interval(c);
        return result;
    }

    // ---- Runs

    void append(std::size_t leaf, std::size_t s) {
        const int k = leaves_[leaf].axis;
        const Slice& slice = slices_[s];
        const auto low = stops_.find({slice.begin, true});
        const bool joins = runs_.size() > leaves_[leaf].first_run && runs_.back().end == slice.begin &&
                           runs_.back().high.kind == Stop::Open && low == stops_.end();
        if (!joins) {
            runs_.push_back({leaf, s, s, slice.begin, slice.end, {}, {}});
            if (low != stops_.end())
                runs_.back().low = low->second;
            else if (slice.begin == domain_[k].lower())
                runs_.back().low = {Stop::Face, static_cast<std::size_t>(2 * k),
                                    point(leaf, slice, slice.begin)};
        }
        Run& run = runs_.back();
        run.last = s + 1;
        run.end = slice.end;
        if (const auto high = stops_.find({slice.end, false}); high != stops_.end())
            run.high = high->second;
        else if (slice.end == domain_[k].upper())
            run.high = {Stop::Face, static_cast<std::size_t>(2 * k + 1), point(leaf, slice, slice.end)};
    }

    Box point(std::size_t leaf, const Slice& s, double t) const {
        return narrowed(f_, s.enclosure, leaves_[leaf].axis, Interval(t));
    }

    const Slice& slice_at(const Run& run, double t) const {
        std::size_t s = run.first;
        while (s + 1 < run.last && slices_[s].end < t) ++s;
        return slices_[s];
    }

    // ---- Connection

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

    void connect() {
        for (std::size_t seed = 0; seed < runs_.size(); ++seed)
            if (runs_[seed].component == none && !known(runs_[seed])) trace(seed);
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
        std::vector<Piece> pieces{{seed, {}, {}}};
        runs_[seed].component = id;
        CurveComponent<D> component;
        std::array<Stop, 2> stops;
        while (const auto next = successor(pieces.back().run, 1, stops[1])) {
            pieces.back().leave = next->point;
            if (runs_[next->run].component == id) {
                // Back on a run of this walk, in the same sense: the curve is closed.
                component.closed = true;
                while (pieces.front().run != next->run) pieces.erase(pieces.begin());
                pieces.front().enter = next->point;
                break;
            }
            if (runs_[next->run].component != none) return;  // all of it is known
            runs_[next->run].component = id;
            pieces.push_back({next->run, next->point, {}});
        }
        if (!component.closed) {
            pieces.back().leave = end_box(pieces.back().run, 1);
            while (const auto before = successor(pieces.front().run, -1, stops[0])) {
                if (runs_[before->run].component == id) {
                    // A run met later in this walk begins before the present first one: the walk starts with
                    // it.
                    while (pieces.front().run != before->run) pieces.erase(pieces.begin());
                    continue;
                }
                pieces.front().enter = before->point;
                runs_[before->run].component = id;
                pieces.insert(pieces.begin(), {before->run, {}, before->point});
            }
            pieces.front().enter = end_box(pieces.front().run, -1);
        }
        for (const Piece& p : pieces) emit(component, p);
        component.joints.push_back(pieces.back().leave);
        if (!component.closed) {
            for (const int end : {0, 1}) {
                component.ends[end].index = stops[end].index;
                if (stops[end].kind == Stop::Undecided) component.ends[end].kind = CurveEnd::Kind::Cluster;
            }
        }
        result_.components.push_back(std::move(component));
    }

    void emit(CurveComponent<D>& component, const Piece& piece) const {
        const Run& run = runs_[piece.run];
        const Leaf& leaf = leaves_[run.leaf];
        const int k = leaf.axis;
        const bool upwards = leaf.direction > 0;
        const Interval in = upwards ? piece.enter[k] : piece.leave[k],
                       out = upwards ? piece.leave[k] : piece.enter[k];
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
                i == 0 ? piece.enter : narrowed(f_, tubes[i].enclosure, k, Interval(tubes[i].begin)));
            component.tubes.push_back(tubes[i]);
        }
    }

    // ---- Clusters

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
    const Box domain_;
    const CurveOptions options_;
    std::array<double, D> unit_;

    std::vector<Part> parts_;
    std::vector<Leaf> leaves_;
    std::vector<Slice> slices_;
    std::size_t divided_slices_ = 0;
    std::vector<Run> runs_;
    std::vector<Box> undecided_;
    // Stops of the leaf at hand, by parameter and whether a run begins there (or ends).
    std::map<std::pair<double, bool>, Stop> stops_;
    CurveSet<D> result_;
};

}  // namespace

template <int N>
CurveSet<N + 1> solve_curves(const CurveSystem<N>& f, const IntervalBox<N + 1>& box,
                             const CurveOptions& options) {
    return in_ieee_arithmetic("solve_curves()", [&] { return Solver<N>(f, box, options).solve(); });
}

template <int N>
IntervalBox<N + 1> point_at(const CurveSystem<N>& f, const Tube<N + 1>& tube, double t) {
    return narrowed<N>(f, tube.enclosure, tube.axis, Interval(t));
}

template <int N>
WideBox<N + 1> point_at(const CurveSystem<N>& f, const Tube<N + 1>& tube, const Wide& t, int bits) {
    constexpr int D = N + 1;
    WideBox<D> y = converted<Wide>(narrowed<N>(f, tube.enclosure, tube.axis, t.enclosure()));
    y[tube.axis] = t;
    double size = 0;
    for (int i = 0; i < D; ++i)
        if (i != tube.axis) size = std::max(size, length(tube.neighbourhood[i]));
    const int enough = std::ilogb(size) - bits - 1;
    int last = INT_MAX;
    // Newton doubles the digits: 53 bits to those of Wide takes a few steps.
    for (int step = 0; step < 16; ++step) {
        int widest = INT_MIN;
        for (int i = 0; i < D; ++i)
            if (i != tube.axis) widest = std::max(widest, y[i].radius_exponent());
        if (widest <= enough || widest >= last) break;
        last = widest;
        const WideBox<D> at = centre(y);
        const Preconditioned<N, Wide> p(f.differentiate(y), tube.axis);
        const auto kept = intersection(p.newton(y, at, p.apply(f(at))), y);
        if (!kept) break;
        y = *kept;
    }
    return y;
}

#define VCELL_CURVES(N)                                                                         \
    template CurveSet<N + 1> solve_curves<N>(const CurveSystem<N>&, const IntervalBox<N + 1>&,  \
                                             const CurveOptions&);                              \
    template IntervalBox<N + 1> point_at<N>(const CurveSystem<N>&, const Tube<N + 1>&, double); \
    template WideBox<N + 1> point_at<N>(const CurveSystem<N>&, const Tube<N + 1>&, const Wide&, int);
VCELL_CURVES(1)
VCELL_CURVES(2)
VCELL_CURVES(3)
#undef VCELL_CURVES

}  // namespace vcell
