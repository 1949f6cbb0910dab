/// What competes around a cylinder before it has a number: which of it ties with others and is left out.
#pragma once

#include <cstddef>
#include <vector>

#include "../forms/axial_ties.hpp"
#include "../forms/wall_ties.hpp"
#include "given_equations.hpp"
#include "radial_objects.hpp"

namespace vcell::cylinder_entries {

/// A form and whose it is.
struct Entry {
    std::vector<Site> sites;
    Object canonical;
    RadialForm form;
    bool is_kept = true;
    bool is_of_floor = false;
    bool is_of_crossing = false;
    FormId id{};
};

/// Sites and what equals one of them: FoundForms::add_twins() adds that only to sites that have a form.
std::vector<Site> with_equal_ones(const std::vector<Site>& sites, const RadialObjects& objects,
                                  std::size_t count);

/// Names what the forms that are kept are of; a wall between crossing axes is none of what was given. Pre:
/// problem.given is filled.
std::vector<GivenForm> given_forms(const std::vector<Entry>& entries, const RadialBaseProblem& problem,
                                   const Box& walls);

/// Ties of what has planes for bisectors, sides of the box, walls between crossing axes and tubes along the
/// base that have its radius, name these by their places among the entries. Where there are more such tubes
/// they take no part, as looking at all pairs would take longer than the cell.
std::vector<WallTie> wall_ties(const std::vector<Entry>& entries, double reach, double most);

/// Leaves out the middle ones, and returns how far these give way. Of walls that are one but for rounding
/// each is the middle one to the other and a third: none is left out for what is left out itself.
double drop_middle(const std::vector<WallTie>& ties, std::vector<Entry>& entries);

/// Leaves out what lies behind a mirror of the base (find_mirror_ties()), adds how it ties, and returns how
/// far it gives way.
double drop_mirrored(const Scene& scene, const Cylinder& base, double most, std::vector<Entry>& entries,
                     std::vector<WallTie>& ties);

/// These name what was left out to the problem; of `count` objects those that equal one of these, too. Pre:
/// what is kept has its number.
void add_ties(const std::vector<AxialTie>& ties, double most_rounded, const std::vector<Entry>& entries,
              const RadialObjects& objects, std::size_t count, RadialBaseProblem& problem);
void add_ties(const std::vector<WallTie>& ties, const std::vector<Entry>& entries,
              const RadialObjects& objects, std::size_t count, RadialBaseProblem& problem);

}  // namespace vcell::cylinder_entries
