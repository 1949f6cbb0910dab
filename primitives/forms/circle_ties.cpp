#include "circle_ties.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vcell {

namespace {

using Point = Eigen::Vector4d;

constexpr std::size_t most_compared = 32;

// Where the form is in that space, but for rounding.
Point point(const CircularForm& f) { return 0.5 / f.w * Point(f.a, f.b, f.e - f.k, f.e + f.k); }

double lowest(const Point& p) { return p[3] - p.head<3>().norm(); }

struct Place {
    FormId form;
    Point at;
};

// The forms that are compared: those that come lowest.
std::vector<Place> candidates(const FormFamily& family) {
    std::vector<Place> places;
    places.reserve(family.forms.size());
    for (const FormId f : family.forms.ids()) places.push_back({f, point(family.forms[f])});
    const auto height = [](const Place& p) { return lowest(p.at); };
    if (places.size() > most_compared) {
        std::ranges::nth_element(places, places.begin() + most_compared, {}, height);
        places.resize(most_compared);
        std::ranges::sort(places, {}, &Place::form);
    }
    return places;
}

// Is c between f and g? Exact.
bool is_between(const FormFamily& family, FormId c, FormId f, FormId g) {
    const ExactForm C = family.exact(c), F = family.exact(f), G = family.exact(g);
    const auto less = [&F](const ExactForm& h) {  // times both denominators
        return std::array<Exact, 4>{h.K * F.W - F.K * h.W, h.A * F.W - F.A * h.W, h.B * F.W - F.B * h.W,
                                    h.C * F.W - F.C * h.W};
    };
    const std::array<Exact, 4> u = less(C), v = less(G);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j)
            if ((u[i] * v[j] - u[j] * v[i]).sign() != Sign::Zero) return false;
    for (int i = 0; i < 4; ++i) {
        const Sign way = v[i].sign();
        if (way != Sign::Zero) return u[i].sign() == way && (v[i] * C.W - u[i] * G.W).sign() == way;
    }
    return false;
}

}  // namespace

std::vector<CircleTie> find_circle_ties(const FormFamily& family) {
    // Rounding does less than that to directions between points that are not next to each other.
    constexpr double apart = 0x1p-20, alike = 0x1p-28;
    const Point somewhere(0.5377, 0.2913, 0.7138, 0.3391);  // tells directions apart that are not alike
    const std::vector<Place> places = candidates(family);
    struct Ray {
        Point direction;
        double length, key;
        FormId to;
    };
    std::vector<CircleTie> ties;
    std::vector<Ray> rays;
    for (const Place& from : places) {
        rays.clear();
        for (const Place& to : places) {
            const Point way = to.at - from.at;
            const double length = way.norm();
            if (!(length > apart * (to.at.norm() + from.at.norm()))) continue;
            rays.push_back({way / length, length, way.dot(somewhere) / length, to.form});
        }
        std::ranges::sort(rays, {}, &Ray::key);
        for (std::size_t i = 0; i < rays.size(); ++i)
            for (std::size_t j = i + 1; j < rays.size() && rays[j].key - rays[i].key < alike; ++j) {
                if (!((rays[i].direction - rays[j].direction).norm() < alike)) continue;
                const bool is_first_nearer = rays[i].length < rays[j].length;
                const FormId near = rays[is_first_nearer ? i : j].to, far = rays[is_first_nearer ? j : i].to;
                // Each is found from both of its ends.
                if (from.form < far && is_between(family, near, from.form, far))
                    ties.push_back({near, {from.form, far}});
            }
    }
    return ties;
}

}  // namespace vcell
