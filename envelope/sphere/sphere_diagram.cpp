// Forms are inserted lowest first, about a tetrahedron of forms that lose in the end; those later that would
// cut a face in two as it is; all in another order if that fails.
#include "sphere_diagram.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "disc_result.hpp"

namespace vcell {

namespace {

using Eigen::Vector3d;
using namespace discs;

class DiscDiagram : DiscResult {
public:
    DiscDiagram(const FormFamily& family, const EnvelopeOptions& options, const TakeMoreForms& more,
                const TiePredicates& ties)
        : DiscResult(family, ties), options_(options), more_(more) {}

    std::optional<MinimizationDiagram> run(std::size_t attempt) {
        const auto owner = insert_all(attempt);
        if (!owner) return std::nullopt;
        auto result = diagram(*owner);
        if (result) result->work.insertions = inserted_;
        return result;
    }
    bool run(std::size_t attempt, DiscArcs& out) { return insert_all(attempt) && set_arcs(out); }

    std::size_t inserted() const { return inserted_; }
    bool is_given_up() const { return is_given_up_; }

private:
    static constexpr std::size_t few_vertices = 64;  // most cells have no more
    static constexpr std::size_t most_spread = 8;    // forms that are to surround the base first

    // Whose face holds the chart's pole; none where that is no common case.
    std::optional<Index> insert_all(std::size_t attempt) {
        double least_slope = HUGE_VAL;
        forms_.reserve(family_.size() + 16);
        for (const CircularForm& f : family_.forms) {
            forms_.push_back(linear(f));
            // The cap has none.
            if (!forms_.back().b.isZero(0)) least_slope = std::min(least_slope, forms_.back().slope);
            steepest_ = std::max(steepest_, forms_.back().slope);
        }
        std::optional<Index> owner = owner_of_pole();
        if (!owner || !(least_slope > 0) || !std::isfinite(least_slope)) return std::nullopt;
        // In each direction a side of the box is nearer than sqrt(3) times the farthest side.
        if (!start(least_slope / 4, attempt < 2 ? 4 : attempt == 2 ? 8 : 16)) return std::nullopt;
        if (!insert_in(insertion_order(attempt))) return std::nullopt;
        for (Index f = static_cast<Index>(family_.size()); f < forms_.size(); ++f)
            if (faces_[f].start != none) return std::nullopt;
        if (more_) {
            if (!take_more()) return std::nullopt;
            owner = owner_of_pole();
        }
        return owner;
    }
    // The chart's pole is (0, 0, -1).
    std::optional<Index> owner_of_pole() const {
        const Vector3d pole(0, 0, -1);
        Index best = 0;
        for (Index f = 1; f < forms_.size(); ++f)
            if (forms_[f](pole) < forms_[best](pole)) best = f;
        for (Index f = 0; f < forms_.size(); ++f)
            if (f != best && !(forms_[f](pole) - forms_[best](pole) > forms_[f].error + forms_[best].error))
                return std::nullopt;
        return best;
    }
    // Lowest first, so that others are soon seen to lose; but before them some of the lowest that lie in all
    // directions, as faces that reach around the sphere are easily cut in two. Which of those is the first is
    // the choice that each attempt makes anew.
    using Order = std::vector<std::pair<double, Index>>;
    Order insertion_order(std::size_t attempt) const {
        Order order;
        order.reserve(family_.size());
        for (Index f = 0; f < family_.size(); ++f) order.emplace_back(forms_[f].e - forms_[f].slope, f);
        std::ranges::sort(order);
        const std::size_t spread = attempt == 0 ? 4 : most_spread;
        const std::size_t low = std::min<std::size_t>(order.size(), 4 * spread);
        std::swap(order[0], order[attempt % low]);
        std::array<Vector3d, 4 * most_spread> direction;
        std::array<double, 4 * most_spread>
            nearness;  // greatest cosine of the angle to a direction that was taken
        for (std::size_t i = 0; i < low; ++i) {
            const Linear& form = forms_[order[i].second];
            direction[i] = form.b / form.slope;
            nearness[i] = -1;
        }
        for (std::size_t taken = 0; taken + 1 < std::min(spread, low); ++taken) {
            std::size_t farthest = taken + 1;
            for (std::size_t i = taken + 1; i < low; ++i) {
                nearness[i] = std::max(nearness[i], direction[i].dot(direction[taken]));
                if (nearness[i] < nearness[farthest]) farthest = i;
            }
            std::swap(order[taken + 1], order[farthest]);
            std::swap(direction[taken + 1], direction[farthest]);
            std::swap(nearness[taken + 1], nearness[farthest]);
        }
        // In rounds that double the diagram, each on a path from neighbour to neighbour, whose faces and
        // vertices then are at hand.
        for (std::size_t begin = 64; begin < order.size(); begin *= 2) {
            const std::size_t end = std::min(2 * begin, order.size());
            for (std::size_t i = begin; i < end; ++i) order[i].first = place_on_path(forms_[order[i].second]);
            std::sort(order.begin() + begin, order.begin() + end);
        }
        return order;
    }
    // Inserts forms that come when all others have been. Those that were to lose are gone.
    bool take_more() {
        forms_.erase(forms_.begin() + static_cast<std::ptrdiff_t>(family_.size()), forms_.end());
        while (true) {
            const std::size_t known = forms_.size();
            faces_.resize(known);
            const MoreForms answer = more_([this] { return marks(); });
            is_given_up_ = answer == MoreForms::GivenUp;
            if (answer != MoreForms::Added) return !is_given_up_;
            double steepest = steepest_;
            Order order;
            for (Index f = static_cast<Index>(known); f < family_.size(); ++f) {
                forms_.push_back(linear(family_.forms[FormId{f}]));
                steepest = std::max(steepest, forms_.back().slope);
                order.emplace_back(forms_.back().e - forms_.back().slope, f);
            }
            faces_.resize(forms_.size());
            if (steepest > steepest_ && !set_steepest(steepest)) return false;
            std::ranges::sort(order);
            if (!insert_in(order)) return false;
        }
    }
    bool insert_in(const Order& order) {
        std::vector<Index> late;
        for (const auto& [place, form] : order) {
            const Insertion insertion = insert(form);
            if (insertion == Insertion::Failed) return false;
            if (insertion == Insertion::Later) {
                late.push_back(form);
                continue;
            }
            note_insertion();
        }
        while (!late.empty()) {
            const std::size_t before = late.size();
            for (Index& form : late) {
                const Insertion insertion = insert(form);
                if (insertion == Insertion::Failed) return false;
                if (insertion == Insertion::Later) continue;
                form = none;
                note_insertion();
            }
            std::erase(late, none);
            // Where hardly any goes in the others hardly will.
            constexpr std::size_t few = 64;
            if (late.size() == before || (late.size() > few && late.size() > before / 2)) return false;
        }
        require_soundness();
        return true;
    }
    void note_insertion() {
        ++inserted_;
        if (std::has_single_bit(inserted_)) require_soundness();
        if (options_.progress && inserted_ % 1024 == 0)
            options_.progress(static_cast<double>(inserted_) / static_cast<double>(family_.size()));
    }
    // Forms that lose in the end, so high are they: -slope t.p for points t of the sphere that no input
    // favours. The first four are the corners of a tetrahedron.
    bool start(double slope, Index count) {
        static const Eigen::Matrix3d turn =
            (Eigen::AngleAxisd(0.7131, Vector3d::UnitX()) * Eigen::AngleAxisd(1.9277, Vector3d::UnitZ()))
                .toRotationMatrix();
        const std::array<Vector3d, 4> corners{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
        const auto first = static_cast<Index>(forms_.size());
        for (const Vector3d& t : corners) {
            const Vector3d direction = turn * t.normalized();
            forms_.push_back(Linear(-slope * direction, 0, 16 * u * slope));
            Vertex vertex;
            vertex.p = -direction;
            vertex.error = 16 * u;
            vertices_.push_back(vertex);
        }
        for (Index i = 0; i < 4; ++i) {
            set_forms(vertices_[i], {first + (i + 1) % 4, first + (i + 2) % 4, first + (i + 3) % 4});
            vertex_rows_.set(i, vertices_[i]);
        }
        // The others on a spiral.
        for (Index i = 4; i < count; ++i) {
            const double z = 1 - (2 * i - 7.0) / (count - 4), angle = 2.4 * i, r = std::sqrt(1 - z * z);
            const Vector3d direction = turn * Vector3d(r * std::cos(angle), r * std::sin(angle), z);
            forms_.push_back(Linear(-slope * direction, 0, 16 * u * slope));
        }
        faces_.assign(forms_.size(), Face());
        // Euler: V = 2 F - 4 and E = 3 F - 6, and some that are gone.
        const std::size_t room = forms_.size() + 64;
        vertices_.reserve(2 * room);
        edges_.reserve(3 * room);
        half_edges_.reserve(6 * room);
        vertex_rows_.reserve(few_vertices);
        apex_rows_.reserve(few_vertices / 2 * 3);
        // Around the face about corner i, counter-clockwise, the vertices opposite to the others.
        constexpr Index around[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
        std::array<std::array<Index, 4>, 4> from_to{};  // the half-edge between two vertices, plus 1
        for (Index i = 0; i < 4; ++i)
            for (int k = 0; k < 3; ++k) {
                const Index a = around[i][k], b = around[i][(k + 1) % 3];
                Index h = from_to[a][b];
                if (h == 0) {
                    h = 2 * static_cast<Index>(edges_.size()) + 1;
                    edges_.push_back({});
                    half_edges_.resize(half_edges_.size() + 2);
                    from_to[b][a] = h + 1;
                }
                from_to[a][b] = h;
                half_edges_[h - 1].origin = a;
                half_edges_[h - 1].face = first + i;
                faces_[first + i].start = h - 1;
            }
        for (Index i = 0; i < 4; ++i)
            for (int k = 0; k < 3; ++k)
                link(from_to[around[i][k]][around[i][(k + 1) % 3]] - 1,
                     from_to[around[i][(k + 1) % 3]][around[i][(k + 2) % 3]] - 1);
        for (Index e = 0; e < edges_.size(); ++e) {
            set_curve(e);
            set_arc(e);
        }
        alive_faces_ = {first, first + 1, first + 2, first + 3};
        for (Index i = 4; i < count; ++i)
            if (insert(first + i) != Insertion::Done) return false;
        return true;
    }

    const EnvelopeOptions& options_;
    const TakeMoreForms& more_;
    std::size_t inserted_ = 0;
    bool is_given_up_ = false;
};

}  // namespace

// What fails in the beginning, when faces are large, may succeed in another order. The more forms there are,
// the less it costs to try again, compared with the other engine.
static bool attempt_all(const FormFamily& family, const EnvelopeOptions& options, const TakeMoreForms& more,
                        const TiePredicates& ties, const auto& run) {
    constexpr std::size_t beginning = 64, many = 1024;
    const std::size_t attempts = family.size() > many ? 16 : 4;
    for (std::size_t attempt = 0; attempt < attempts; ++attempt) {
        DiscDiagram diagram(family, options, more, ties);
        if (run(diagram, attempt)) return true;
        if (diagram.inserted() > beginning || diagram.is_given_up()) break;
    }
    return false;
}

std::optional<MinimizationDiagram> disc_diagram_on_sphere(const FormFamily& family,
                                                          const EnvelopeOptions& options) {
    std::optional<MinimizationDiagram> result;
    attempt_all(family, options, {}, {}, [&](DiscDiagram& diagram, std::size_t attempt) {
        result = diagram.run(attempt);
        return result.has_value();
    });
    return result;
}

bool disc_arcs_on_sphere(const FormFamily& family, const TakeMoreForms& more, const TiePredicates& ties,
                         DiscArcs& arcs) {
    return attempt_all(family, {}, more, ties,
                       [&](DiscDiagram& diagram, std::size_t attempt) { return diagram.run(attempt, arcs); });
}

}  // namespace vcell
