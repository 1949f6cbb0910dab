#include "space_guide.hpp"

#include <algorithm>
#include <cmath>

#include "../../core/numbers/jet.hpp"
#include "../../core/solver/newton/box.hpp"

namespace vcell::space_fit {

namespace {

const SpaceBox nowhere{Vector4d::Constant(infinity), Vector4d::Constant(-infinity)};

void extend(SpaceBox& corners, const std::array<Interval, 4>& X) {
    for (int i = 0; i < 4; ++i) {
        corners[0][i] = std::min(corners[0][i], X[i].lower());
        corners[1][i] = std::max(corners[1][i], X[i].upper());
    }
}

template <class T>
std::array<T, 4> point_over(const std::array<T, 3>& foot, const std::array<T, 3>& normal, const T& t) {
    return {t * normal[0] + foot[0], t * normal[1] + foot[1], t * normal[2] + foot[2], t};
}

bool holds(const std::array<double, 4>& box, const Vec2& q) {
    return q.x() >= box[0] && q.x() <= box[1] && q.y() >= box[2] && q.y() <= box[3];
}

}  // namespace

Interval StripPart::mean_value(const Interval& value, const std::array<Interval, 2>& gradient,
                               const Vec2& at) const {
    const Interval gx = gradient[0], gy = gradient[1], dx(direction.x()), dy(direction.y()), x(at.x()),
                   y(at.y());
    const Interval by_sides =
        value + gx * (Interval(box[0], box[1]) - x) + gy * (Interval(box[2], box[3]) - y);
    const Interval by_strip = value + (gy * dx - gx * dy) * (across - (dx * y - dy * x)) +
                              (gx * dx + gy * dy) * (along - (dx * x + dy * y));
    return intersection(by_sides, by_strip).value_or(by_sides);
}

ArcGuide::Rays ArcGuide::rays(const Chart::Part& part) const {
    const auto& [x0, x1, y0, y1] = part.box;
    const Interval x(x0, x1), y(y0, y1);
    Rays r{chart_.foot(x, y), normal(x, y, part.is_back), {}, {}};
    for (const int k : {0, 1}) {
        const Equation& G = equations_.sites[k];
        const Interval t = G.distance_along(r.foot, r.normal);
        r.doubts[k] = G.doubt_along(r.foot, r.normal, t);
        r.distances[k] = t + r.doubts[k];
    }
    return r;
}

SpaceBox ArcGuide::enclosure(const std::array<double, 4>& box) const {
    SpaceBox corners = nowhere;
    chart_.for_parts(box, [&](const Chart::Part& part) {
        const auto [f, w, distances, doubts] = rays(part);
        const auto& [a, b] = distances;
        const double low = std::max({a.lower(), b.lower(), 0.0}), high = std::min(a.upper(), b.upper());
        extend(corners, point_over(f, w, Interval(std::min(low, high), std::max(low, high))));
    });
    return corners;
}

SpaceBox ArcGuide::enclosure(const StripPart& strip) const {
    const SpaceBox corners = enclosure(strip.box);
    SpaceBox tight = nowhere;
    chart_.for_parts(strip.box, [&](const Chart::Part& part) {
        StripPart here = strip;
        here.box = part.box;
        const auto doubts = rays(part).doubts;
        const auto left = over(here, part.is_back, 0, doubts[0]),
                   right = over(here, part.is_back, 1, doubts[1]);
        extend(tight, intersection(left, right).value_or(left));
    });
    return {tight[0].cwiseMax(corners[0]), tight[1].cwiseMin(corners[1])};
}

SpaceBox ArcGuide::rim_enclosure(const Node& from, const Node& to, double slack) const {
    const double y = std::get<Plane>(arc_.sites[1].object).point.y();
    const Vec3 v = from.X.head<3>() / from.X[3], w = to.X.head<3>() / to.X[3];
    // Where the ends may be, and how far the circle is from its chord.
    const double room = sqrt2 * slack / std::min(from.X[3], to.X[3]) + rounding + (v - w).squaredNorm();
    const auto over = [&](int i) {
        return Interval(std::min(v[i], w[i]), std::max(v[i], w[i])) + Interval::ball(0, room);
    };
    const Vector3i foot{Interval(0), Interval(y), Interval(0)}, normal{over(0), Interval(0), over(2)};
    const Interval t = equations_.sites[0].distance_along(foot, normal);
    SpaceBox corners = nowhere;
    extend(corners, {t * normal[0], Interval(y), t * normal[2], t});
    return corners;
}

template <class T>
T ArcGuide::distance_along(int k, const T& x, const T& y, bool is_back) const {
    return equations_.sites[k].distance_along(chart_.foot(x, y), normal(x, y, is_back));
}

std::array<Interval, 4> ArcGuide::over(const StripPart& strip, bool is_back, int k,
                                       const Interval& doubt) const {
    const auto point = [&](const auto& x, const auto& y) {
        const auto f = chart_.foot(x, y), w = normal(x, y, is_back);
        return point_over(f, w, distance_along(k, x, y, is_back));
    };
    const auto& [x0, x1, y0, y1] = strip.box;
    const Interval x(x0, x1), y(y0, y1);
    using Coordinate = Jet<Interval, 2>;
    const auto at = point(Interval(x.mid()), Interval(y.mid()));
    const auto jets = point(Coordinate::variable(x, 0), Coordinate::variable(y, 1));
    const auto w = normal(x, y, is_back);
    std::array<Interval, 4> X;
    for (int i = 0; i < 4; ++i)
        X[i] = strip.mean_value(at[i], jets[i].gradient, {x.mid(), y.mid()}) + (i < 3 ? doubt * w[i] : doubt);
    return X;
}

// Are the distances of both sites certainly different all over the part? Next to a node they differ by far
// less than each of them changes over a small box: the mean value theorem tells their difference.
bool ArcGuide::is_off_arc(const StripPart& strip, bool is_back) const {
    const Rays over = rays({strip.box, is_back});
    const auto& [a, b] = over.distances;
    if (a.upper() < b.lower() || b.upper() < a.lower()) return true;
    const auto difference = [&](const auto& x, const auto& y) {
        return distance_along(0, x, y, is_back) - distance_along(1, x, y, is_back);
    };
    const auto& [x0, x1, y0, y1] = strip.box;
    const Interval x(x0, x1), y(y0, y1);
    using Height = Jet<Interval, 2>;
    const Height slopes = difference(Height::variable(x, 0), Height::variable(y, 1));
    const Interval value = strip.mean_value(difference(Interval(x.mid()), Interval(y.mid())), slopes.gradient,
                                            {x.mid(), y.mid()}) +
                           over.doubts[0] + over.doubts[1];
    return !value.contains(0);
}

bool ArcGuide::is_off_arc(const StripPart& strip) const {
    bool is_off = true;
    chart_.for_parts(strip.box, [&](const Chart::Part& part) {
        StripPart here = strip;
        here.box = part.box;
        is_off = is_off && is_off_arc(here, part.is_back);
    });
    return is_off;
}

SpaceBox ArcGuide::enclosure_between(const Node& from, const Node& to, const Piece& piece, double slack,
                                     std::size_t& cells_left) const {
    const Vec2 &d = piece.direction, n(-d.y(), d.x());
    const std::array ends{chart_point(from.X, piece), chart_point(to.X, piece)};
    double left = infinity, right = -infinity;
    const auto hold = [&](const Vec2& q, double error) {
        left = std::min(left, n.dot(q) - error);
        right = std::max(right, n.dot(q) + error);
    };
    for (const int k : {0, 1}) {
        const Node& node = k == 0 ? from : to;
        const Vec2& q = ends[k];
        hold(q, chart_.chart_error(node.X, q, slack, rounding));
        if (!node.ends_piece) continue;
        // The true end of the piece is near the node.
        const bool opens_edge = &piece == &arc_.pieces.front();
        const Piece& before = opens_edge ? arc_.pieces.back() : *(&piece - 1);
        const Vec2 first = chart_.continued(before.end, piece.box);
        const bool is_first = !(opens_edge && arc_.start) && (first - q).norm() < (piece.end - q).norm();
        hold(is_first ? first : piece.end, is_first ? before.error : piece.error);
    }
    const auto part = [&](double a, double b) {
        const Interval s(left, right), t(std::min(a, b), std::max(a, b));
        const Interval x = s * n.x() + t * d.x(), y = s * n.y() + t * d.y();
        return StripPart{d,
                         s,
                         t,
                         {std::max(piece.box[0], x.lower()), std::min(piece.box[1], x.upper()),
                          std::max(piece.box[2], y.lower()), std::min(piece.box[3], y.upper())}};
    };
    // Finer cells than this part of the strip's width tell little more.
    constexpr double finest = 0.125;
    // From where on, between a and b, there may be an arc.
    int cells = 0;
    const auto cut = [&](const auto& self, double a, double b) -> double {
        constexpr int most_cells = 1000;
        if (cells_left > 0) --cells_left;
        const double middle = 0.5 * (a + b);
        const StripPart cell = part(a, b);
        if (cell.box[0] > cell.box[1] || cell.box[2] > cell.box[3] || is_off_arc(cell)) return b;
        if (++cells > most_cells || cells_left == 0 || !(std::abs(b - a) > finest * (right - left)) ||
            middle == a || middle == b)
            return a;
        const double first = self(self, a, middle);
        return first == middle ? self(self, middle, b) : first;
    };
    const double center = 0.5 * d.dot(ends[0] + ends[1]);
    double reach = 0;
    for (const double x : {piece.box[0], piece.box[1]})
        for (const double y : {piece.box[2], piece.box[3]})
            reach = std::max(reach, std::abs(d.dot(Vec2(x, y)) - center));
    const double low = cut(cut, center - reach, center);
    cells = 0;
    const double high = cut(cut, center + reach, center);
    return low < high ? enclosure(part(low, high)) : enclosure(piece.box);
}

std::optional<Vec2> ArcGuide::meet(const Vec2& q, const Piece& piece) const {
    const auto found = approach(q, piece.direction);
    return found && holds(piece.box, *found) ? found : bisect(q, piece);
}

// Where the ray over a point meets the bisector of site k.
Vector4d ArcGuide::met(int k, const Vec3& foot, const Vec3& normal) const {
    const double t = equations_.sites[k].distance_along(foot, normal);
    Vector4d X;
    X << t * normal + foot, t;
    return X;
}

// Between the sides of the piece's box: the line may meet the two again beyond them.
std::optional<Vec2> ArcGuide::bisect(const Vec2& q, const Piece& piece) const {
    constexpr int halvings = 60;
    const Vec2& d = piece.direction;
    double low = -infinity, high = infinity;
    for (const int i : {0, 1}) {
        const double a = (piece.box[2 * i] - q[i]) / d[i], b = (piece.box[2 * i + 1] - q[i]) / d[i];
        if (d[i] == 0) continue;
        low = std::max(low, std::min(a, b));
        high = std::min(high, std::max(a, b));
    }
    const auto is_left_nearer = [&](double s) {
        const Vec2 p = q + s * d;
        const Vec3 foot = chart_.foot(p), normal = chart_.normal(p);
        if (equations_.has_difference) return equations_[2](met(0, foot, normal)) > 0;
        // Negative or infinite distances are those of rays that do not get there.
        return 1 / equations_.sites[0].distance_along(foot, normal) >
               1 / equations_.sites[1].distance_along(foot, normal);
    };
    if (!(low < high) || !is_left_nearer(low) || is_left_nearer(high)) return std::nullopt;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        (is_left_nearer(middle) ? low : high) = middle;
    }
    return q + low * d;
}

// Newton's method, as near as a search in space needs it.
std::optional<Vec2> ArcGuide::approach(Vec2 q, const Vec2& direction) const {
    constexpr int enough = 20;
    constexpr double near = 1e-4;
    for (int i = 0; i < enough; ++i) {
        const Vec3 f = chart_.foot(q), w = chart_.normal(q);
        const Vec3 moving = chart_.foot(direction), turning = chart_.normal_derivative(q, direction);
        if (equations_.has_difference) {
            // Along the left one's bisector.
            const Vector4d X = met(0, f, w), g = equations_.sites[0].gradient(X),
                           h = equations_[2].gradient(X);
            const Vec3 across = X[3] * turning + moving;
            const double rise = g.head<3>().dot(across) / (-g[3] - g.head<3>().dot(w));
            const double value = equations_[2](X),
                         step = value / (h.head<3>().dot(across + rise * w) + h[3] * rise);
            if (!std::isfinite(step)) return std::nullopt;
            q -= step * direction;
            if (std::abs(value) <= near * X[3]) return q;
            continue;
        }
        std::array<double, 2> t, slope;
        for (int k = 0; k < 2; ++k) {
            const Equation& G = equations_.sites[k];
            t[k] = G.distance_along(f, w);
            Vector4d X;
            X << t[k] * w + f, t[k];
            // 0 = dG = (g.w - kappa) dt + g.(t dw + df)
            const Vector4d g = G.gradient(X);
            slope[k] = g.head<3>().dot(t[k] * turning + moving) / (-g[3] - g.head<3>().dot(w));
        }
        const double step = (t[0] - t[1]) / (slope[0] - slope[1]);
        if (!std::isfinite(step)) return std::nullopt;
        q -= step * direction;
        if (std::abs(t[0] - t[1]) <= near * (t[0] + t[1])) return q;
    }
    return std::nullopt;
}

}  // namespace vcell::space_fit
