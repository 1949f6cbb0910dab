#include "cylinder_entries.hpp"

#include <algorithm>
#include <cstdint>
#include <variant>

#include "cylinder_forms.hpp"
#include "mirror_ties.hpp"

namespace vcell::cylinder_entries {

std::vector<Site> with_equal_ones(const std::vector<Site>& sites, const RadialObjects& objects,
                                  std::size_t count) {
    std::vector<Site> all = sites;
    for (std::uint32_t i = 0; objects.has_merged() && i < count; ++i) {
        const std::uint32_t owner = objects.owner(i);
        if (owner == RadialObjects::none || owner == i) continue;
        if (std::ranges::find(sites, objects.site(owner)) != sites.end()) all.push_back(objects.site(i));
    }
    return all;
}

std::vector<GivenForm> given_forms(const std::vector<Entry>& entries, const RadialBaseProblem& problem,
                                   const Box& walls) {
    std::vector<GivenForm> forms;
    for (const Entry& e : entries) {
        if (!e.is_kept) continue;
        const Site own = e.sites.front();
        forms.push_back(e.is_of_crossing  ? GivenForm()
                        : own.is_object() ? GivenForm(problem.given[e.id])
                                          : GivenForm(WorldSide(walls, own.index)));
    }
    return forms;
}

std::vector<WallTie> wall_ties(const std::vector<Entry>& entries, double reach, double most) {
    constexpr std::size_t most_flat = 64;
    const auto is_flat = [](const Entry& e) {
        return std::holds_alternative<Cylinder>(e.canonical) && !e.form.has_root() &&
               e.form.b0.sign() == Sign::Zero;
    };
    const bool with_flat = static_cast<std::size_t>(std::ranges::count_if(entries, is_flat)) <= most_flat;
    std::vector<std::uint32_t> places;
    std::vector<RadialForm> walls;
    // Three sides of the box have no line in common, and what ties all along the axis is told already.
    bool has_crossing = false;
    int oblique_sides = 0;
    for (std::uint32_t i = 0; i < entries.size(); ++i) {
        const Entry& e = entries[i];
        const bool is_side = e.sites.front().kind == Site::Kind::BoxSide && !e.is_of_floor;
        if (!e.is_kept || (!is_side && !e.is_of_crossing && !(with_flat && is_flat(e)))) continue;
        walls.push_back(e.form);
        places.push_back(i);
        has_crossing = has_crossing || e.is_of_crossing;
        oblique_sides += is_side && !cylinder_forms::CylinderForms::is_same_along_axis(e.form);
    }
    if (!has_crossing && oblique_sides < 2) return {};
    std::vector<WallTie> ties = find_wall_ties(walls, reach, most);
    for (WallTie& tie : ties) tie = {places[tie.middle], places[tie.first], places[tie.second], tie.off};
    return ties;
}

double drop_middle(const std::vector<WallTie>& ties, std::vector<Entry>& entries) {
    double gives_way = 0;
    for (const WallTie& tie : ties) {
        gives_way = std::max(gives_way, tie.off);
        if (entries[tie.first].is_kept && entries[tie.second].is_kept) entries[tie.middle].is_kept = false;
    }
    return gives_way;
}

double drop_mirrored(const Scene& scene, const Cylinder& base, double most, std::vector<Entry>& entries,
                     std::vector<WallTie>& ties) {
    double gives_way = 0;
    std::vector<const Object*> objects;
    for (const Entry& e : entries) {
        const Site own = e.sites.front();
        const bool takes_part = e.is_kept && !e.is_of_floor && own.is_object();
        objects.push_back(takes_part ? &scene.objects[scene.place(own.index)] : nullptr);
    }
    for (const MirrorTie& tie : find_mirror_ties(base, objects, most)) {
        entries[tie.hidden].is_kept = false;
        gives_way = std::max(gives_way, tie.off);
        ties.push_back({tie.hidden, tie.mirrored, tie.mirror, tie.off});
    }
    return gives_way;
}

void add_ties(const std::vector<AxialTie>& ties, double most_rounded, const std::vector<Entry>& entries,
              const RadialObjects& objects, std::size_t count, RadialBaseProblem& problem) {
    for (const AxialTie& tie : ties) {
        const Entry &before = entries[tie.before], &after = entries[tie.after];
        if (!before.is_kept || !after.is_kept) continue;  // behind a mirror
        for (const Site site : with_equal_ones(entries[tie.middle].sites, objects, count))
            problem.generator_ties.push_back({site, before.id, after.id, tie.move <= most_rounded});
    }
}
void add_ties(const std::vector<WallTie>& ties, const std::vector<Entry>& entries,
              const RadialObjects& objects, std::size_t count, RadialBaseProblem& problem) {
    for (const WallTie& tie : ties) {
        const Entry &first = entries[tie.first], &second = entries[tie.second];
        if (!first.is_kept || !second.is_kept || entries[tie.middle].is_kept) continue;
        for (const Site site : with_equal_ones(entries[tie.middle].sites, objects, count))
            problem.common_ties.push_back({site, first.id, second.id});
    }
}

}  // namespace vcell::cylinder_entries
