#include "lone_points.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace vcell {

void drop_lone_points(CellMesh& mesh) {
    constexpr std::uint32_t none = UINT32_MAX;
    std::vector<std::uint32_t> number(mesh.points.size(), none);
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t p : t) number[p] = 0;
    std::vector<Vec3> kept;
    for (std::size_t p = 0; p < number.size(); ++p) {
        if (number[p] == none) continue;
        number[p] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(mesh.points[p]);
    }
    mesh.points = std::move(kept);
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& p : t) p = number[p];
    for (auto& line : mesh.edge_lines) {
        if (std::ranges::any_of(line, [&](std::uint32_t p) { return number[p] == none; })) line.clear();
        for (std::uint32_t& p : line) p = number[p];
    }
}

}  // namespace vcell
