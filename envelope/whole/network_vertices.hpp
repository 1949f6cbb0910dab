/// The vertices of a void network, each of which several cells have.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "network_sites.hpp"

namespace vcell::whole {

class NetworkVertices {
public:
    /// A vertex as a cell has it.
    struct Sight {
        std::uint32_t cell;  ///< whose
        NetworkSites sites;  ///< the cell's own object is one
        Vec3 point;
        double clearance, error;
        bool is_touching;
        /// Which vertex of the network it is, when that is known, and where that has to be moved to be here.
        std::uint32_t vertex = UINT32_MAX;
        Image by{0, 0, 0};
    };
    /// Instead of a sight: what is no vertex of the network, and where a cell is cut.
    static constexpr std::uint32_t none = UINT32_MAX, at_cut = UINT32_MAX - 1;

    /// The names are kept by reference.
    explicit NetworkVertices(const SiteNames& names)
        : names_(names),
          cells_(names.decided().scene().objects.size(), 0),
          sights_of_(cells_.size(), {0, 0}) {}

    /// Takes the vertices of a cell: which sight each is. Pre: both cells of a plane come one after the
    /// other.
    std::vector<std::uint32_t> add(std::uint32_t object, const Cell& cell);
    /// How many cells of the object have come: of a plane there may be two.
    std::uint32_t cells(std::uint32_t object) const { return cells_[object]; }

    /// Appends the vertices, ascending by sites, and tells all sights which they are. Throws UndecidedError
    /// as VoidNetworkBuilder::finish(). Pre: all cells have come; once.
    void find(std::vector<NetworkVertex>& vertices);
    const Sight& sight(std::uint32_t number) const { return sights_[number]; }

private:
    // A sight in another cell of the same vertex, and where that cell is as seen from the first one's.
    struct OtherSight {
        std::uint32_t sight;
        Image image;
    };

    Image image_of(const Sight& a, const Sight& b, const NetworkSite& site) const;
    bool are_apart(const Sight& a, const Sight& b, const Image& image) const;
    static bool has_lesser_objects(const Sight& a, const Sight& b);
    OtherSight sight_of(const Sight& sight, const NetworkSite& site) const;
    NetworkVertex vertex_of(std::uint32_t sight, std::uint32_t number);

    const SiteNames& names_;
    std::vector<std::uint32_t> cells_;
    std::vector<Sight> sights_;
    std::vector<std::array<std::uint32_t, 2>> sights_of_;  // of each object: from, to
    std::vector<std::uint32_t> by_objects_;  // sights, each object's by the objects that they have
};

}  // namespace vcell::whole
