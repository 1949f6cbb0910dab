/// The cells of a diagram, one by one, each among as few objects as prove it complete.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../cell.hpp"
#include "../voronoi_diagram.hpp"
#include "cell_bound.hpp"
#include "hidden_objects.hpp"
#include "image_tree.hpp"
#include "other_images.hpp"

namespace vcell::whole {

/// Throws what voronoi_diagram() throws about a scene.
void validate_diagram(const DiagramScene& scene);
/// Where the box repeats coordinates become multiples of one power of two, few enough digits that sums of
/// several edges are exact, and tubes are along such sums. Returns a bound on the distance that they were
/// moved by. Pre: validated.
double snap_to_grid(DiagramScene& scene);

/// Is the point inside, and on no side?
inline bool holds(const Box& box, const Vec3& p) {
    return (p.array() > box.min.array()).all() && (p.array() < box.max.array()).all();
}

/// What is known of a scene that is too large to be known everywhere.
struct ScenePart {
    DiagramScene scene;  ///< of some of the objects, validated and on the grid
    std::vector<std::uint32_t>
        numbers;                      ///< that they have in the whole scene, ascending; empty: all are here
    std::vector<std::string> hidden;  ///< find_hidden() of the whole scene
    std::size_t balls = 0;            ///< in the whole scene, without hidden ones
    double moved = 0;                 ///< snap_to_grid()
};

/// A scene that cells are computed of: what is periodic on its grid, balls in a tree, hidden balls known.
/// Objects go by their places; where they are a part of the scene's, results and messages have their numbers.
class DecidedDiagram {
public:
    /// Throws as voronoi_diagram().
    explicit DecidedDiagram(const DiagramScene& scene);
    explicit DecidedDiagram(ScenePart part);

    const DiagramScene& scene() const { return part_.scene; }
    double moved() const { return part_.moved; }
    std::uint32_t number(std::uint32_t i) const { return part_.numbers.empty() ? i : part_.numbers[i]; }
    /// Pre: the object of that number is known.
    std::uint32_t place(std::uint32_t number) const {
        return part_.numbers.empty()
                   ? number
                   : static_cast<std::uint32_t>(std::ranges::lower_bound(part_.numbers, number) -
                                                part_.numbers.begin());
    }
    bool is_ball(std::uint32_t i) const { return std::holds_alternative<Sphere>(scene().objects[i]); }
    const Sphere& ball(std::uint32_t i) const { return std::get<Sphere>(scene().objects[i]); }
    bool is_wall(std::uint32_t i) const { return is_vessel(scene().objects[i]); }
    /// Are all objects balls, and do cells end nowhere but between them and at the box?
    bool is_simple() const { return others_.empty() && !scene().probe; }
    struct Other {
        std::uint32_t place;
        OtherImages images;
    };
    /// Objects that are no balls and are not hidden, ascending.
    const std::vector<Other>& others() const { return others_; }
    /// own_periods() of an object of the scene; of a ball none.
    std::span<const Image> periods(std::uint32_t i) const;
    /// VoronoiDiagram::periods, of the objects that are known.
    std::vector<ObjectImage> all_periods() const;
    const Lattice& lattice() const { return lattice_; }
    /// What stands for all images of another object, or of object i itself, that are the given one as seen
    /// from some image of object i that is object i.
    Image image_beside(std::uint32_t i, const ObjectImage& other) const;
    /// All balls that are not hidden, by their places.
    const ImageTree& balls() const { return balls_; }
    /// Why the object has no cell; empty: it has one.
    const std::string& hidden(std::uint32_t i) const { return part_.hidden[i]; }

    /// Is the cell found among what may touch a bound of it? Otherwise it is found among all objects.
    bool is_bounded(std::uint32_t i) const;
    /// The box in which a ball's cell is computed: where the scene repeats, one that the cell does not reach
    /// the sides of, as it lies in that of the ball among its own images.
    Box room(const Sphere& ball) const;

    struct Competitors {
        std::vector<ImageTree::Found> nearest;
        /// No ball that is farther from the ball's centre is among them, whatever else the scene has.
        double reach;
    };
    /// The nearest balls, images included, so many of them: they bound a ball's cell to begin with.
    Competitors competitors(std::uint32_t i, std::size_t count) const {
        return competitors(ball(i), i, count);
    }
    /// The nearest to a ball's centre, but for the ball `self`, none being UINT32_MAX.
    Competitors competitors(const Sphere& ball, std::uint32_t self, std::size_t count) const;
    /// Few bound most cells nearly as well as all. Where they do not, along the sides of a box, many do.
    static constexpr std::size_t few = 28, many = 112;

    struct Bound {
        CellBound bound;
        double last;  ///< how far the last of the few competitors is

        /// That balls of sectors are narrowed to.
        double width() const { return 0.375 * last; }
        /// Does it reach so far that many competitors are worth their time?
        bool is_poor() const { return bound.reach() > 4 * last; }
    };
    /// What these competitors, ascending, the room and the probe bound the cell of `base` by.
    Bound bound(const Sphere& base, std::span<const ImageTree::Found> nearest) const;
    /// Few competitors bound the cell, or many where that is poor. All that may touch the bound, and nothing
    /// else, is looked at.
    Bound bound(std::uint32_t i) const;

    /// May object `x` touch the cell of object i, whose reach that is?
    bool may_touch(std::uint32_t x, std::uint32_t i, double reach) const;

private:
    void index();

    ScenePart part_;
    Lattice lattice_;
    std::vector<Other> others_;
    ImageTree balls_;
};

/// Balls that lie together, and those around them: their cells are found among these, and what else may touch
/// them is searched for.
class Neighborhood {
public:
    Neighborhood(const DecidedDiagram& decided, const BallTree::Leaf& leaf);
    /// Of a ball alone.
    Neighborhood(const DecidedDiagram& decided, std::uint32_t object);

    /// Images included, in no order.
    std::span<const ImageTree::Found> balls() const { return balls_; }
    /// Holds all balls whose surfaces are no farther from the centre of any of those that lie together, as
    /// doubles have that distance.
    double reach() const { return reach_; }
    /// Are they around those images of the balls that the tree has, not around the balls where they lie
    /// (ImageTree::home())?
    bool is_in_box() const { return is_in_box_; }

private:
    void set_reach(double reach, const Box& box);

    bool is_in_box_ = false;
    double reach_;
    std::vector<ImageTree::Found> balls_;
};

/// What a cell of a ball gives to those of its neighbours of greater numbers: their parts of the volume, as
/// seen through the faces that they share, in the order of its contacts.
struct SharedParts {
    struct Part {
        double volume, error;
    };
    bool is_sharing = false;  ///< otherwise the cell is complete by itself, and gives nothing
    std::vector<Part> parts;
};
struct FoundCell {
    DiagramCell cell;
    SharedParts shared;
};

/// The cell of an object, complete by itself. Where `cell` is asked for it gets that of a computed ball,
/// whose sites are numbered as the diagram's objects, or the complete cell of a tube, if there is one, which
/// then is what is measured. Throws nothing that is about this cell alone. Pre: all balls are known that may
/// touch its bound, and all within the reach of its competitors, and where the diagram is simple and no cell
/// is asked for, what measured_ball_cell() searches for; of objects that are not bounded, everything.
DiagramCell find_cell(const DecidedDiagram& decided, std::uint32_t object, std::optional<Cell>* cell);
/// The cell of a ball where all others are asked for, too. Pre: that of find_cell(); the diagram is simple.
FoundCell find_sharing_cell(const DecidedDiagram& decided, std::uint32_t object, const Neighborhood& around);

}  // namespace vcell::whole
