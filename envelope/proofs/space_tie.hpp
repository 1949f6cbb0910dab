/// Ties told by the equations of the forms in space: exact, whatever the chart's coordinates are.
///
/// All are equations of degree two in X = (p, t, 1), the base too, and a line of the chart is one of degree
/// one (primitives/forms/space_quadrics.hpp). What forms have in common (balls of one radius, parallel tubes)
/// leaves combinations of degree one: planes. In these the others are written, and so on. Then
///
///   * a form ties wherever some others do if its equation is a combination of theirs;
///   * two conics in a plane touch where a member of their pencil is singular whose parameter is a double
///   root of the
///     pencil's determinant: a pair of lines, in the point that they share, or a double line, where the
///     others cross it.
///
/// A point that this leaves has coordinates a + b sqrt(c).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../../primitives/forms/exact_heights.hpp"
#include "../../primitives/forms/form_family.hpp"
#include "../../primitives/forms/space_quadrics.hpp"

namespace vcell {

/// A point X / X[4], X[4] > 0, with coordinates in one field.
using SpacePoint = std::array<OneRoot, 5>;

class SpaceTie {
public:
    /// A line a x + b y + c = 0 of the chart.
    struct ChartLine {
        double a, b, c;
    };

    /// All but those that run along the axis of a cylinder or obliquely to it.
    static bool can_see(const FormFamily& family, const ChartLine& line) {
        return space_quadrics::line_equation(family, line.a, line.b, line.c).has_value();
    }

    /// Pre: can_see(family, *line).
    SpaceTie(const FormFamily& family, std::span<const FormId> forms,
             const std::optional<ChartLine>& line = {});

    /// Takes any equations, that of the base among them.
    SpaceTie(const FormFamily& family, std::vector<space_quadrics::Quadric> equations,
             const std::optional<ChartLine>& line = {});

    /// Has the form the others' height wherever these have one and the same, t > 0?
    bool implies(FormId form) const;
    /// An equation holds wherever the others do, or where they do and a linear form of X is not zero.
    struct Implied {
        std::optional<space_quadrics::Linear> beside;
    };
    /// None if it does neither.
    std::optional<Implied> implied(const space_quadrics::Quadric& equation) const;
    /// Points in which all have one height, and more than two forms, or forms and the line, are not
    /// transversal: gradients of heights are on one line, along the chart's line of them all are the same.
    /// All such points, unless there are more unknowns than this can see through: then none.
    std::vector<SpacePoint> tangencies() const;
    /// The points in which all have one height, if no more than a root is left to take. Pre, likewise.
    std::vector<SpacePoint> points() const;

private:
    using Row = std::vector<Exact>;

    Row restricted(const Row& quadric) const;
    Row remainder(const Row& quadric) const;
    std::optional<Row> multiple_of(const Row& linear) const;
    std::optional<space_quadrics::Linear> other_factor(const Row& quadric, const Row& linear) const;
    static std::optional<std::size_t> pivot_of(const Row& linear);
    static Row substituted(const Row& linear, const Row& l, std::size_t p);
    static Row within(const Row& quadric, const Row& l, std::size_t p);
    bool impose(const Row& linear);
    void reduce();
    std::vector<SpacePoint> roots(const Row& quadric, bool is_double) const;
    SpacePoint to_space(const std::vector<OneRoot>& y) const;

    const FormFamily& family_;
    std::size_t dimension_ = 4;  // d: of the flat that everything lies in
    std::array<Row, 5> flat_;    // X[i] = sum of flat_[i][k] y_k, k = 0 .. d; X[4] is a multiple of y_d
    std::vector<Row> quadrics_;  // in y; in echelon form as far as they have no y_d in them
    bool is_empty_ = false;
};

/// Encloses the chart's coordinates of a point. None where it is the pole, or t is not positive.
std::optional<std::array<Interval, 2>> chart_point(const FormFamily& family, const SpacePoint& p);
/// With many digits.
std::optional<std::array<Wide, 2>> wide_chart_point(const FormFamily& family, const SpacePoint& p);

/// Does X satisfy the base's equation and those of all of these? Exact.
bool is_tie_at(const FormFamily& family, std::span<const FormId> forms, const SpacePoint& p);

/// The point in rational coordinates and the square root of one, as its distance t, that (p, t) with many
/// digits is taken to stand for; nothing is proved about it. None if there is no such point. extent: of all
/// places.
std::optional<SpacePoint> space_point_near(const std::array<Wide, 4>& X, double extent);

/// Have two forms equal gradients in a point in which they tie? Exact.
bool have_equal_gradients(const FormFamily& family, FormId f, FormId g, const SpacePoint& p);
/// Equations may be given instead, that of the base first.
bool have_equal_gradients(const std::array<space_quadrics::Quadric, 3>& equations, const SpacePoint& p);
/// Are the gradients of three heights that tie on one line? Exact; of equations, that of the base first.
bool have_gradients_in_line(const std::array<space_quadrics::Quadric, 4>& equations, const SpacePoint& p);
/// Two forms are always; pre: there are no more than three.
bool have_gradients_in_line(const FormFamily& family, std::span<const FormId> forms, const SpacePoint& p);

/// Do two forms that tie change alike along a line of the chart? Exact.
bool have_equal_slopes(const FormFamily& family, FormId f, FormId g, const SpacePoint& p,
                       const SpaceTie::ChartLine& line);

/// Does a form have this point's height there? Pre: t > 0.
bool passes_through(const FormFamily& family, FormId f, const SpacePoint& p);

/// Encloses the coordinates of a point by themselves, X[4] = 1.
std::array<Interval, 5> enclosure(const SpacePoint& p);

/// Is a x + b y + c = 0 in the chart?
bool is_on_line(const FormFamily& family, const SpacePoint& p, const SpaceTie::ChartLine& line);

}  // namespace vcell
