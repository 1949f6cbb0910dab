/// Is a diagram whole, and are its cells what counting points tells?
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"
#include "../primitives/reference.hpp"

namespace vcell {

/// Has a tube no cell as its axis all but touches what it runs through from within, which is refused?
inline bool touches_from_within(const DiagramCell& cell) {
    return cell.reason.find("contains a cross section of the base") != std::string::npos;
}

inline void check_whole(const DiagramScene& scene, const VoronoiDiagram& diagram) {
    for (std::size_t i = 0; i < diagram.cells.size(); ++i) {
        CAPTURE(i);
        CAPTURE(diagram.cells[i].reason);
        using State = DiagramCell::State;
        const State state = diagram.cells[i].state;
        CHECK((state == State::Computed || state == State::Empty));
        CHECK(diagram.cells[i].assumed == 0);
    }
    const ContactTable table = contacts(diagram);
    for (const std::string& fault : table.faults) FAIL_CHECK(fault);
    const FilledVolume sum = filled_volume(scene, diagram);
    CAPTURE(sum.volume);
    CAPTURE(sum.error);
    CAPTURE(sum.box);
    CHECK(sum.fills());
    CHECK(sum.error < 1e-6 * sum.box);
}

/// Cells of equal states and contacts, volumes and areas within their bounds: cells may have been computed
/// among different objects.
inline void check_alike(const VoronoiDiagram& one, const VoronoiDiagram& other) {
    REQUIRE(one.cells.size() == other.cells.size());
    for (std::size_t i = 0; i < one.cells.size(); ++i) {
        const DiagramCell &a = one.cells[i], &b = other.cells[i];
        CAPTURE(i);
        REQUIRE(a.state == b.state);
        if (a.state != DiagramCell::State::Computed) continue;
        CHECK(std::abs(a.volume - b.volume) <= a.volume_error + b.volume_error);
        REQUIRE(a.contacts.size() == b.contacts.size());
        for (std::size_t k = 0; k < a.contacts.size(); ++k) {
            const CellContact &c = a.contacts[k], &d = b.contacts[k];
            CHECK(c.site == d.site);
            CHECK(c.image == d.image);
            CHECK(std::abs(c.area - d.area) <= c.area_error + d.area_error);
        }
    }
}

/// The share of the box that is nearest to each object, by counting points, images included.
inline std::vector<double> sampled_volumes(const DiagramScene& scene, std::mt19937_64& rng, int samples) {
    std::vector<double> counts(scene.objects.size(), 0);
    const Eigen::Matrix3d edges = scene.edges();
    std::uniform_real_distribution<double> unit(0, 1);
    for (int s = 0; s < samples; ++s) {
        const Vec3 p = scene.box.min + edges * Vec3(unit(rng), unit(rng), unit(rng));
        double least = HUGE_VAL;
        std::size_t owner = 0;
        for (int a = -1; a <= 1; ++a)
            for (int b = -1; b <= 1; ++b)
                for (int c = -1; c <= 1; ++c) {
                    if ((a != 0 && !scene.periodic[0]) || (b != 0 && !scene.periodic[1]) ||
                        (c != 0 && !scene.periodic[2]))
                        continue;
                    for (std::size_t i = 0; i < scene.objects.size(); ++i)
                        if (const double d = distance(scene.objects[i], p - edges * Vec3(a, b, c));
                            d < least) {
                            least = d;
                            owner = i;
                        }
                }
        ++counts[owner];
    }
    for (double& c : counts) c *= edges.determinant() / samples;
    return counts;
}

inline void check_sampled(const DiagramScene& scene, const VoronoiDiagram& diagram, std::mt19937_64& rng) {
    constexpr int samples = 20000;
    const std::vector<double> sampled = sampled_volumes(scene, rng, samples);
    const double box = scene.edges().determinant();
    for (std::size_t i = 0; i < sampled.size(); ++i) {
        // Six standard deviations of a count, and one point.
        const double share = diagram.cells[i].volume / box;
        const double doubt =
            box * (6 * std::sqrt(std::max(0.0, share * (1 - share)) / samples) + 6.0 / samples);
        CAPTURE(i);
        CHECK(std::abs(sampled[i] - diagram.cells[i].volume) <= doubt);
    }
}

}  // namespace vcell
