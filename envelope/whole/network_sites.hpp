/// Whose vertices and edges a void network has, as the cells of a diagram tell.
#pragma once

#include <cstdint>
#include <vector>

#include "cell_finder.hpp"
#include "void_network.hpp"

namespace vcell::whole {

/// Ascending; of each object that is no ball the representative of its images.
using NetworkSites = std::vector<NetworkSite>;

/// Names sites as the diagram does, seen from one cell or another.
class SiteNames {
public:
    /// The diagram is kept by reference.
    explicit SiteNames(const DecidedDiagram& decided) : decided_(decided) {}

    const DecidedDiagram& decided() const { return decided_; }
    const Object& object(std::uint32_t number) const { return decided_.scene().objects[number]; }
    /// An image of an object, where it is.
    Object object(const NetworkSite& site) const;
    /// What a site of a cell is. Pre: it is an object; the cell is the diagram's.
    const Object& object(const Cell& cell, const Site& site) const;

    /// What stands for all images that differ by the object's own periods.
    NetworkSite representative(NetworkSite site) const;
    /// A site of a cell; at the end of a tube's stretch the side of the box, if there is one.
    NetworkSite site_in(const Cell& cell, const Site& site) const;
    /// These sites of the object's cell, and the object itself.
    NetworkSites sites_in(const Cell& cell, std::uint32_t object, const std::vector<Site>& sites) const;
    /// Names the sites as they are seen from an image of the box.
    NetworkSites seen_from(NetworkSites sites, const Image& image) const;

    struct Owned {
        NetworkSites sites;  ///< as seen from the owner
        NetworkSite owner;
    };
    /// Whose cell has what all of these have in common, an edge or a face: the smallest ball's; if there is
    /// none the smallest tube's, or the smallest plane's. Pre: they are objects, not all of them vessels.
    Owned seen_from_owner(const NetworkSites& sites) const;

private:
    const DecidedDiagram& decided_;
};

}  // namespace vcell::whole
