/// Curves as SVG paths.
#pragma once

#include <string>
#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell {

struct SvgPaths {
    int digits = 7;
    double tolerance = 0;  ///< of curves that SVG has no words for, in the picture's units

    std::string number(double x) const;
    std::string pair(const Vec2& p) const;
    void move_to(std::string& path, const RationalCurve2& c) const;
    /// Appends the curve to a path that has reached its start. Lines, parabolas, circular arcs and polynomial
    /// cubics have words of their own, other curves become cubics.
    void append(std::string& path, const RationalCurve2& c) const;
    void append(std::string& path, const std::vector<Vec2>& line, const char* close) const;
    /// A polyline whose points are on a smooth curve: where that is a circle or a straight line, as one.
    void append_smooth(std::string& path, const std::vector<Vec2>& line) const;

private:
    bool append_exact(std::string& path, const std::vector<Eigen::Vector3d>& p) const;
    void append_cubics(std::string& path, const RationalCurve2& c, double from, double to, int depth) const;
    bool append_arc(std::string& path, const std::vector<Vec2>& line) const;
};

}  // namespace vcell
