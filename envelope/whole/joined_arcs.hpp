/// The arcs of edges in the cell of a tube or a plane, joined where that cell is cut.
///
/// The cell of a tube or a plane in a box that repeats is one period of it, and around a tube that is oblique
/// to the box cells come in parts that keep a little clear of each other (complete_tube.hpp). An edge that
/// runs on beyond a cut has an arc on either side of it, and these two are one if there is a ball about both
/// of their ends in which
///
///     the gradients of the three distances turn so little, by their surfaces' curvature, that any chord of
///     the trisector is within 30 degrees of its direction in the middle: it is one arc then, along which
///     that direction ascends, and comes from one of the ends to the other one before it leaves the ball;
///     one of the two arcs starts along that direction, the other one against it;
///     all other objects are farther by more than distances change on the way, and sides of the box farther
///     than that.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../cell.hpp"
#include "cell_finder.hpp"
#include "void_network.hpp"

namespace vcell::whole {

/// Does a cell end there though the box does not, so that edges run on? Pre: the site has gone
/// through side_at_end().
bool is_cut(const DecidedDiagram& decided, const Site& site);

/// An arc of an edge, as a cell has it.
struct CutArc {
    const CellEdge* edge;
    std::vector<NetworkSite> sites;  ///< ascending, representatives; the cell's own object is one
    /// Where it starts and ends; none where the cell is cut, and where it is closed.
    std::array<std::optional<std::uint32_t>, 2> vertices;
};

struct JoinedArcs {
    std::vector<std::uint32_t> arcs;  ///< one after the other, each in either sense
    std::vector<Image> images;        ///< of each, as it lies in the edge that begins with the first one
    std::optional<std::array<std::uint32_t, 2>> vertices;
    /// Where the second vertex is as seen from the first arc; without vertices, where that arc comes again.
    Image image{0, 0, 0};
    Interval length_between{0.0};               ///< of what is between the arcs
    std::optional<Interval> clearance_between;  ///< all values there
};

/// All edges that the arcs are parts of, in the order of their first ones. Throws UndecidedError where an
/// end at a cut is not proved to go on. Pre: the arcs' edges are the cell's, which is the object's.
std::vector<JoinedArcs> join_arcs(const DecidedDiagram& decided, std::uint32_t object, const Cell& cell,
                                  std::span<const CutArc> arcs);

}  // namespace vcell::whole
