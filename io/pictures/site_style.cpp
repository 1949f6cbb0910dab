#include "site_style.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <utility>
#include <vector>

namespace vcell {

namespace {
constexpr std::array<std::string_view, 8> colours{"#77aadd", "#ee8866", "#eedd88", "#ffaabb",
                                                  "#99ddff", "#44bb99", "#bbcc33", "#aaaa00"};
}

std::span<const std::string_view> palette() { return colours; }

std::array<int, 3> channels(std::string_view colour) {
    std::array<int, 3> rgb{};
    for (std::size_t k = 0; k < 3; ++k) {
        const char* digits = colour.data() + 1 + 2 * k;
        std::from_chars(digits, digits + 2, rgb[k], 16);
    }
    return rgb;
}

// Take away an object of smallest remaining degree until none is left; colour in the opposite order.
// A planar graph always has a vertex of degree 5 at most, so each object then meets at most five colours.
std::unordered_map<std::uint32_t, std::size_t> object_colours(const Cell& cell) {
    std::unordered_map<std::uint32_t, std::set<std::uint32_t>> adjacent;
    for (const CellFace& f : cell.faces)
        if (f.site.is_object()) adjacent[f.site.index];
    for (const CellEdge& e : cell.edges)
        if (e.sites[0].is_object() && e.sites[1].is_object() && e.sites[0] != e.sites[1]) {
            adjacent[e.sites[0].index].insert(e.sites[1].index);
            adjacent[e.sites[1].index].insert(e.sites[0].index);
        }

    std::set<std::pair<std::size_t, std::uint32_t>> by_degree;
    std::unordered_map<std::uint32_t, std::size_t> degree;
    for (const auto& [object, others] : adjacent) {
        degree[object] = others.size();
        by_degree.insert({others.size(), object});
    }
    std::vector<std::uint32_t> order;
    while (!by_degree.empty()) {
        const std::uint32_t object = by_degree.begin()->second;
        by_degree.erase(by_degree.begin());
        order.push_back(object);
        for (const std::uint32_t other : adjacent[object])
            if (by_degree.erase({degree[other], other})) by_degree.insert({--degree[other], other});
    }

    std::unordered_map<std::uint32_t, std::size_t> result;
    std::array<std::size_t, colours.size()> used{};  // in the whole picture: spread evenly
    for (auto object = order.rbegin(); object != order.rend(); ++object) {
        std::array<std::size_t, colours.size()> beside{};
        for (const std::uint32_t other : adjacent[*object])
            if (const auto c = result.find(other); c != result.end()) ++beside[c->second];
        std::size_t best = 0;
        for (std::size_t c = 1; c < colours.size(); ++c)
            if (std::pair(beside[c], used[c]) < std::pair(beside[best], used[best])) best = c;
        result[*object] = best;
        ++used[best];
    }
    return result;
}

std::string site_title(const Scene& scene, Site site) {
    if (site.is_object()) return object_title(scene, site.index);
    if (site.kind == Site::Kind::Base) return "the base";
    if (site.kind == Site::Kind::Cap) return "the cap";
    const std::string name = to_string(site);  // "box:-x", "end:+"
    return (site.kind == Site::Kind::BoxSide ? "box side " : "end ") + name.substr(name.find(':') + 1);
}

std::int32_t base_number(const Scene& scene) {
    return scene.base_object ? static_cast<std::int32_t>(*scene.base_object) : -1;
}

std::string cell_title(std::int32_t number, const Cell& cell) {
    std::string title = number < 0 ? "cell" : "cell " + std::to_string(number);
    if (!cell.scene.base_name.empty()) title += " (" + cell.scene.base_name + ")";
    return title;
}

}  // namespace vcell
