/// Functions of two coordinates with their derivatives of first and second order, in Interval or Wide.
#pragma once

#include "../../core/platform.hpp"

namespace vcell {

template <class T>
struct FunctionJet {
    T v, x, y, xx, xy, yy;

    static FunctionJet constant(const T& t) { return {t, T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)}; }

    friend FunctionJet operator+(const FunctionJet& a, const FunctionJet& b) {
        return {a.v + b.v, a.x + b.x, a.y + b.y, a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
    }
    friend FunctionJet operator-(const FunctionJet& a) { return {-a.v, -a.x, -a.y, -a.xx, -a.xy, -a.yy}; }
    friend FunctionJet operator*(const T& s, const FunctionJet& a) {
        return {s * a.v, s * a.x, s * a.y, s * a.xx, s * a.xy, s * a.yy};
    }
    friend FunctionJet operator*(const FunctionJet& a, const FunctionJet& b) {
        const T two(2.0);
        return {a.v * b.v,
                a.v * b.x + a.x * b.v,
                a.v * b.y + a.y * b.v,
                a.v * b.xx + two * (a.x * b.x) + a.xx * b.v,
                a.v * b.xy + a.x * b.y + a.y * b.x + a.xy * b.v,
                a.v * b.yy + two * (a.y * b.y) + a.yy * b.v};
    }
    /// From a = q b differentiated.
    friend FunctionJet operator/(const FunctionJet& a, const FunctionJet& b) {
        const T two(2.0);
        FunctionJet q;
        q.v = a.v / b.v;
        q.x = (a.x - q.v * b.x) / b.v;
        q.y = (a.y - q.v * b.y) / b.v;
        q.xx = (a.xx - two * (q.x * b.x) - q.v * b.xx) / b.v;
        q.xy = (a.xy - q.x * b.y - q.y * b.x - q.v * b.xy) / b.v;
        q.yy = (a.yy - two * (q.y * b.y) - q.v * b.yy) / b.v;
        return q;
    }
    /// From r^2 = a differentiated.
    friend FunctionJet sqrt(const FunctionJet& a) {
        const T half(0.5);
        FunctionJet r;
        r.v = sqrt(a.v);
        r.x = half * a.x / r.v;
        r.y = half * a.y / r.v;
        r.xx = (half * a.xx - square(r.x)) / r.v;
        r.xy = (half * a.xy - r.x * r.y) / r.v;
        r.yy = (half * a.yy - square(r.y)) / r.v;
        return r;
    }
    friend FunctionJet square(const FunctionJet& a) {
        FunctionJet s = a * a;
        s.v = square(a.v);
        return s;
    }
};

}  // namespace vcell
