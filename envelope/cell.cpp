#include "cell.hpp"

namespace vcell {

std::string to_string(CurveKind kind) {
    switch (kind) {
        case CurveKind::Line:
            return "line";
        case CurveKind::Circle:
            return "circle";
        case CurveKind::Ellipse:
            return "ellipse";
        case CurveKind::Parabola:
            return "parabola";
        case CurveKind::Hyperbola:
            return "hyperbola";
        case CurveKind::Spline:
            break;
    }
    return "spline";
}

}  // namespace vcell
