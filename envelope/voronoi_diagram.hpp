/// The Voronoi diagram of objects in a box: the cells of all of them.
///
/// A cell is computed among few objects and is the cell among all of them: whatever is not among those is
/// proved to be too far. An object as near to a point of a cell's boundary as the cell's own object, at a
/// clearance r there, is no farther than 2 r from that object's surface, as distances change no faster than
/// places. So what is at least DiagramCell::reach away touches nothing, reach being twice the largest
/// clearance. Before the cell is known its nearest competitors bound it, direction by direction, and what can
/// touch it is found in a tree (whole/cell_bound.hpp).
///
/// All cells see the same scene: around balls and points forms are exact, so neighbours cannot disagree about
/// what lies between them. contacts() pairs the two sides of every face and names those that do not fit.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cell.hpp"

namespace vcell {

/// Objects that share a box, none of them the base of the others. Lengths in the scene's unit.
struct DiagramScene {
    std::vector<Object> objects;
    std::vector<std::string> names;  ///< empty, or one (possibly empty) name for each object
    /// Empty, or a label for each object: objects of one label belong together (group_table()).
    std::vector<std::string> groups;
    Box box;
    /// Along these axes the box repeats, by its edges. Then balls are less than 2^13 edges away; the axis of
    /// a tube leaves through a side that does not repeat, or is along a whole combination of at most 16 of
    /// each edge, after which the tube closes on itself; planes and vessels are where they were after every
    /// edge.
    std::array<bool, 3> periodic{false, false, false};
    /// Where the box repeats it may lean: its edges are (x, 0, 0), (xy, y, 0) and (xz, yz, z), these being
    /// xy, xz, yz. Zero along axes that do not repeat. Pre: leaning boxes repeat along all axes.
    std::array<double, 3> tilt{0, 0, 0};
    /// Cells end at this clearance (Scene::probe): what a ball of that radius that touches the object
    /// covers with its centre, and what is behind.
    std::optional<double> probe;
    std::string units = "mm";
    std::optional<double> tolerance;  ///< as Scene::tolerance

    bool is_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
    /// The edges of the box, as columns.
    Eigen::Matrix3d edges() const;
};

/// What a cell shares with one neighbour: an object, or a side of the box.
struct CellContact {
    Site site;
    std::array<std::int16_t, 3> image{0, 0, 0};  ///< of the neighbour: moved by so many edges of the box
    std::uint32_t faces = 0;                     ///< connected ones
    double area = 0, area_error = 0;
};

struct DiagramCell {
    enum class State : std::uint8_t {
        Computed,
        Empty,      ///< the object lies in another one, or equals one of a lower number
        Undecided,  ///< digits or a budget were not enough
        Wall,       ///< a vessel, or a plane among hollow cones: what is nearest to walls has no cell
        Refused,    ///< the object cuts or touches another one in a way that leaves it without a cell
    };

    State state = State::Computed;
    std::string reason;  ///< of all but Computed
    /// The part of the box nearest to the object has it, body included; a plane has both of its sides.
    double volume = 0, volume_error = 0;
    double area = 0, area_error = 0;  ///< without the sides of the box, and without the cap
    /// Of the cap, which no other object is near (DiagramScene::probe): the accessible surface, at the
    /// probe's distance.
    double exposed_area = 0, exposed_error = 0;
    /// What the object itself takes of the cell (DiagramOptions::bodies): over all cells, the union of balls
    /// and tubes in the box, those included that are refused a cell. `body_estimated`: the error, which
    /// otherwise is a proven bound.
    double body_volume = not_measured, body_error = not_measured;
    bool body_estimated = false;
    /// NaN for planes, tubes and balls centred outside the box, or on its sides, along axes that do not
    /// repeat, whose cells have no faces over base points there.
    double min_clearance = 0, max_clearance = 0;
    bool touches_box = false;
    bool is_estimated = false;  ///< the errors, otherwise proven bounds
    double reach = 0;  ///< what is as far from the object's surface, or farther, does not touch the cell
    std::uint32_t candidates = 0;       ///< objects that were looked at, images counted
    std::uint64_t assumed = 0;          ///< coincidences that were taken for granted (Decisions::assumed)
    std::vector<CellContact> contacts;  ///< ascending by site and image
};

struct VoronoiDiagram {
    std::vector<DiagramCell> cells;  ///< one for each object
    /// A bound on the distance that coordinates were moved by: to a binary grid on which the box repeats
    /// exactly, and tubes within one period to whole combinations of its edges.
    double moved = 0;
    /// Moves by so many edges of a box that repeats leave these objects, which are no balls, as they are.
    /// Ascending by number; all such moves of an object are sums of its ones. Images in contacts stand for
    /// all that differ by what leaves one of the two objects as it is.
    std::vector<ObjectImage> periods;
};

struct DiagramOptions {
    unsigned threads = 0;  ///< 0: as many as the machine has cores. The result is the same for any number
    /// Called now and then by the calling thread with the fraction of cells that is done; may throw to
    /// cancel.
    std::function<void(double fraction)> progress;
    /// Called by the calling thread with each computed cell of a ball, ascending by object, and kept
    /// no longer. Its scene has the objects that were looked at; its sites
    /// are their numbers in the diagram, or where the box repeats, as images have no numbers, their places in
    /// that scene, whose `images` tell what they are.
    std::function<void(std::uint32_t object, const Cell& cell)> visit;
    /// `visit` is called with the complete cells of tubes and planes, too, where there are any
    /// (CellOptions::complete): two of a plane, on its two sides. A tube's measures are then those of that
    /// cell, whose bounds are some times as wide; those of a plane were found without.
    bool complete = false;
    /// The objects' own volumes are asked for, too (DiagramCell::body_volume).
    bool bodies = false;
};

/// Throws InputError for objects that are none (validate()), an empty list, periods with what does not fit
/// into a box that repeats, a probe that is not positive, and a tilt without periods. What one cell runs into
/// is in its state.
VoronoiDiagram voronoi_diagram(const DiagramScene& scene, const DiagramOptions& options = {});

/// The diagram after `objects[number]` has become `object`: only cells that the old or the new one may touch
/// are computed again, or all where it makes the grid of a box that repeats a coarser or a finer one. Pre:
/// the diagram is that of the scene. The scene is changed, too. Throws as voronoi_diagram() does; what is no
/// scene is refused before anything is changed.
void update(VoronoiDiagram& diagram, DiagramScene& scene, std::uint32_t number, const Object& object,
            const DiagramOptions& options = {});

/// A pair of neighbours.
struct Contact {
    std::uint32_t first;
    Site second;                        ///< a side of the box, or an object of a number that is not lower
    std::array<std::int16_t, 3> image;  ///< of the second
    std::uint32_t faces;
    double area, area_error;  ///< as both cells have it
};

struct ContactTable {
    std::vector<Contact> contacts;  ///< ascending by first, second and image
    /// Pairs of computed cells of which only one has faces with the other, or whose areas do not agree within
    /// their errors: none, if all is right.
    std::vector<std::string> faults;
};
ContactTable contacts(const VoronoiDiagram& diagram);

/// The sum of all volumes, and of the box without them, each with its error: a complete diagram leaves
/// nothing, unless cells end at a probe; of scenes with vessels, what is nearest to their walls and to
/// planes without a cell, or beyond the walls.
struct FilledVolume {
    double volume = 0, error = 0, box = 0;
    bool is_estimated = false;
    /// Does the enclosure of the sum hold the box's volume?
    bool fills() const { return volume - error <= box && box <= volume + error; }
};
FilledVolume filled_volume(const DiagramScene& scene, const VoronoiDiagram& diagram);

/// The sum of the volumes that objects themselves take of their cells, and of the box: the part of the box
/// that is in no ball and no tube is 1 - volume / box. NaN where one was not asked for or could not be told.
FilledVolume body_volume(const DiagramScene& scene, const VoronoiDiagram& diagram);

}  // namespace vcell
