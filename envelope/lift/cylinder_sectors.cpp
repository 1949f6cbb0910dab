#include "cylinder_sectors.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "../../primitives/objects/message.hpp"
#include "cylinder_turns.hpp"
#include "space_arc.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

// A face that is seen under more from A has several patches.
constexpr double widest_view = 2.5;
// The mean of points around a face that is seen under no more is a middle as good as any.
constexpr double narrow_view = 1;
constexpr std::size_t sector_count = 3;

double angle_of(const Vector2d& q) { return std::atan2(q.y(), q.x()); }
double turn_between(const Vector2d& p, const Vector2d& q) {
    return std::atan2(p.x() * q.y() - p.y() * q.x(), p.dot(q));
}

// May A lie on an edge? Not on an arc whose pieces' cells it is outside of.
bool may_pass(const MinimizationDiagram& diagram, EdgeId e, const Vector2d& A, double error) {
    for (const MinimizationDiagram::ArcPiece& piece : diagram.pieces(e)) {
        const auto& [x0, x1, y0, y1] = piece.box;
        if (A.x() >= x0 - error && A.x() <= x1 + error && A.y() >= y0 - error && A.y() <= y1 + error)
            return true;
    }
    if (!diagram.edges[e].on_rim()) return false;
    const Vector2d from = diagram.vertices[diagram.start(e)].point - A,
                   along = diagram.vertices[diagram.end(e)].point - A - from;
    const double t = std::clamp(-from.dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (from + t * along).norm() <= error;
}

// How the loops of a face go round A.
struct Round {
    double turn = 0;          // of all loops
    bool is_closed = false;   // does one go round A?
    double from = 0, to = 0;  // of the widest loop
    double size = 0;          // how far away from A the boundary is, about
    std::vector<double> of_vertices;
};

Round round_of(const FaceLoops& loops, FaceId face, const Vector2d& A) {
    Round all;
    double sum = 0;
    std::size_t count = 0;
    for (const CcbId ccb : loops[face]) {
        std::optional<Vector2d> last;
        double angle = 0, begin = 0, from = 0, to = 0;
        loops.follow(ccb, [&](const Vector2d& p, bool is_begin, bool is_vertex) {
            const Vector2d q = p - A;
            if (is_begin && is_vertex) all.of_vertices.push_back(angle_of(q));
            if (last)
                angle += turn_between(*last, q);
            else
                angle = begin = from = to = angle_of(q);
            from = std::min(from, angle);
            to = std::max(to, angle);
            sum += q.norm();
            ++count;
            last = q;
        });
        all.turn += angle - begin;
        const bool is_closed = std::abs(angle - begin) > pi;
        if (!is_closed && (all.is_closed || !(to - from > all.to - all.from))) continue;
        all.from = from;
        all.to = to;
        all.is_closed = is_closed;
    }
    all.size = sum / static_cast<double>(count);
    return all;
}

}  // namespace

CylinderSectors::CylinderSectors(const PlaneDiagram& of, const FaceLoops& loops) : diagram_(of.diagram) {
    frames_.resize(diagram_.dcel.face_count());
    holds_tip_.resize(diagram_.dcel.face_count());
    if (std::ranges::any_of(diagram_.cylinders, &CylinderForm::is_hollow))
        sectors_.resize(diagram_.dcel.face_count());
    for (const FaceId face : diagram_.face_forms.ids())
        if (const FormId form = diagram_.face_forms[face]; form.valid() && !diagram_.is_circular(form))
            add_face(of, loops, face);
}

void CylinderSectors::refuse_edges_through_tip(const PlaneDiagram& of, const FaceLoops& loops, FaceId face,
                                               const CylinderHeight& height) const {
    const Vector2d A = height.focus();
    const double error =
        64 * std::numeric_limits<double>::epsilon() * (A.norm() + height.reach() / height.steep());
    loops.around(face, [&](EdgeId e, bool) {
        if (!may_pass(diagram_, e, A, error)) return;
        throw UndecidedError(
            "object " + to_string(of.main_site(diagram_.face_forms[face])) +
            ": an edge of its face may run through the tip of its bisector at " +
            to_text(Vec3(of.problem.unit * of.problem.frame.to_world({A.x(), A.y(), height.depth()}))));
    });
}

// One patch is about the mean of points around the face, which lies in the region with them. From next to the
// region a face is seen under half a turn: with the mean at one end of that the patch is about the middle.
void CylinderSectors::add_face(const PlaneDiagram& of, const FaceLoops& loops, FaceId face) {
    const FormId id = diagram_.face_forms[face];
    const CylinderForm& form = of.problem.family.cylinder(id);
    Vector2d sum = Vector2d::Zero();
    double count = 0;
    const auto add = [&](const Vector2d& p) {
        sum += p;
        ++count;
    };
    loops.around(loops[face].front(), [&](EdgeId e, bool reversed) {
        const VertexId v = reversed ? diagram_.end(e) : diagram_.start(e);
        if (v.valid()) add(diagram_.vertices[v].point);
        for (const auto& piece : diagram_.pieces(e)) add(piece.end);
    });
    const Vector2d mean = sum / count;
    if (of.problem.axes[id.value - diagram_.forms.size()] == AxisToBase::Parallel) {
        frames_[face] = CylinderFrame(form, mean);
        return;
    }
    const CylinderHeight height(form, mean);
    const Vector2d A = height.focus();
    if (form.is_hollow()) refuse_edges_through_tip(of, loops, face, height);
    const Round round = round_of(loops, face, A);
    holds_tip_[face] = std::lround(round.turn / (2 * pi)) == 1;
    const auto frame_towards = [&](double angle) {
        return CylinderFrame(form, A + round.size * Vector2d(std::cos(angle), std::sin(angle)));
    };
    const double middle = 0.5 * (round.from + round.to), view = round.to - round.from;
    if (!form.is_hollow()) {
        const double off = std::abs(std::remainder(angle_of(mean - A) - middle, 2 * pi));
        const bool is_at_end = view > narrow_view && off + 0.5 * view > widest_view;
        frames_[face] = is_at_end ? frame_towards(middle) : CylinderFrame(form, mean);
        return;
    }
    if (!round.is_closed && view <= widest_view) {
        // From far away, where a tube is all but level, directions tell no place near the face.
        frames_[face] = view <= narrow_view ? CylinderFrame(form, mean) : frame_towards(middle);
        return;
    }
    const double start = radial::clear_angle(round.of_vertices, sector_count), width = 2 * pi / sector_count;
    for (std::size_t i = 0; i < sector_count; ++i) {
        const double from = start + width * static_cast<double>(i);
        sectors_[face].push_back({from, from + width, frame_towards(from + 0.5 * width)});
    }
    frames_[face] = sectors_[face].front().frame;
}

// Along a seam the sector is that of the face, which lies at smaller angles where the boundary comes to A.
std::uint32_t CylinderSectors::between(FaceId face, const Vector2d& from, const Vector2d& to) const {
    const std::vector<CylinderSector>& all = sectors_[face];
    const Vector2d A = all.front().frame.height().focus(), p = from - A, q = to - A;
    const double inwards = q.norm() < p.norm() ? -seam_inwards : seam_inwards,
                 angle = angle_of(p) + 0.5 * turn_between(p, q) + inwards;
    const auto off_middle = [&](const CylinderSector& s) {
        return std::abs(std::remainder(angle - s.middle(), 2 * pi));
    };
    return static_cast<std::uint32_t>(std::ranges::min_element(all, {}, off_middle) - all.begin());
}

std::array<double, 2> CylinderSectors::along(EdgeId e, const Vector2d& A) const {
    const VertexId start = diagram_.start(e), end = diagram_.end(e);
    const auto pieces = diagram_.pieces(e);
    Vector2d last = (start.valid() ? diagram_.vertices[start].point : pieces.back().end) - A;
    const double from = angle_of(last);
    double turn = 0;
    const auto go_to = [&](const Vector2d& p) {
        turn += turn_between(last, p - A);
        last = p - A;
    };
    for (std::size_t i = 0; i + 1 < pieces.size(); ++i) go_to(pieces[i].end);
    go_to(end.valid() ? diagram_.vertices[end].point : pieces.back().end);
    return {from, turn};
}

}  // namespace vcell
