/// What the meshes of a diagram's cells share: points, polylines of edges, triangles of faces, and where they
/// are found again.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../../envelope/whole/cell_finder.hpp"
#include "../../envelope/whole/void_network.hpp"
#include "part_ends.hpp"
#include "triangulate.hpp"

namespace vcell::shared {

using Image = std::array<std::int16_t, 3>;
using SharedId = std::uint64_t;
using MeetingSites = std::vector<NetworkSite>;  // ascending, the cell's own object among them
constexpr Image unmoved{0, 0, 0};

inline Image sum(const Image& a, const Image& b) {
    Image result;
    for (std::size_t k = 0; k < 3; ++k) result[k] = static_cast<std::int16_t>(a[k] + b[k]);
    return result;
}
inline Image opposite(const Image& a) {
    Image result;
    for (std::size_t k = 0; k < 3; ++k) result[k] = static_cast<std::int16_t>(-a[k]);
    return result;
}
inline NetworkSite moved(NetworkSite site, const Image& by) {
    if (site.site.is_object()) site.image = sum(site.image, by);
    return site;
}

/// A point of several meshes, by its number and by how many edges of the box it is moved: so it has one place
/// in each, however it came there.
struct SharedPoint {
    SharedId id;
    Image image;
    Vec3 unmoved_place;

    SharedPoint at(const Image& by) const { return {id, sum(image, by), unmoved_place}; }
    std::pair<SharedId, Image> key() const { return {id, image}; }
};

/// What is stored lies as seen from the cell that drew it; its own object is there at image 0, 0, 0.
struct SharedLine {
    SharedId id;
    std::vector<SharedPoint> points;  // of a closed one the first comes again in the end
    Vec3 inner;  // a point of the curve, unmoved: of two arcs with the same ends it is on one
    MeetingSites sites;
    bool is_closed;
    double error;
};

struct SharedVertex {
    SharedPoint point;
    MeetingSites sites;  // all that cells so far have listed
    double error;
    bool is_touching;
    std::vector<std::shared_ptr<SharedLine>> lines;  // that end here and in a vertex of no lower number
};

/// One of the lines around a face, and which way the face's loops run along it.
struct BorderLine {
    SharedId line;
    Image image;
    bool is_reversed;

    friend auto operator<=>(const BorderLine&, const BorderLine&) = default;
};

struct SharedFace {
    std::uint32_t owner;
    NetworkSite beyond;
    std::vector<BorderLine> border;  // ascending
    std::vector<SharedPoint> points;
    std::vector<Triangle> triangles;  // into points
    std::vector<Vec3> normals;
    std::vector<Triangle> corner_normals;
    /// Sides inside of it that join points of its lines, into points: other faces may have both of these.
    std::vector<MeshSide> across;
};

/// A stored thing in the list of one of its objects, which is there at that image.
struct ListedLine {
    std::shared_ptr<SharedLine> what;
    Image image;
};
/// With what tells most vertices apart, so that they need not be looked up.
struct ListedVertex {
    std::shared_ptr<SharedVertex> what;
    Image image;
    Vec3 place;    // unmoved
    double error;  // infinite where it bounds nothing

    ListedVertex(std::shared_ptr<SharedVertex> vertex, const Image& in)
        : what(std::move(vertex)),
          image(in),
          place(what->point.unmoved_place),
          error(what->is_touching ? std::numeric_limits<double>::infinity() : what->error) {}
};
template <class T>
using Lists = std::unordered_map<std::uint32_t, std::vector<T>>;

struct HashPlace {
    std::size_t operator()(const std::pair<SharedId, Image>& place) const {
        const auto& [x, y, z] = place.second;
        return static_cast<std::size_t>(place.first * 27) + static_cast<std::size_t>(9 * x + 3 * y + z);
    }
};

inline std::size_t common_sites(const MeetingSites& stored, const Image& by, const MeetingSites& own) {
    return static_cast<std::size_t>(std::ranges::count_if(
        stored, [&](const NetworkSite& s) { return std::ranges::binary_search(own, moved(s, by)); }));
}

/// A vertex of the cell that is being drawn: which stored one it is.
struct CellPoint {
    SharedPoint point;
    std::shared_ptr<SharedVertex> vertex;
};

/// A line of that cell.
struct CellLine {
    SharedId id;
    Image image;
    bool is_reversed;                 // the stored line runs against the edge
    std::vector<SharedPoint> points;  // from the edge's start to its end
};

/// Everything that cells so far have drawn and others may have, too.
class Store {
public:
    explicit Store(const DiagramScene& scene) : has_come_(scene.objects.size(), false) {
        if (scene.is_periodic()) decided_.emplace(scene);
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
            if (auto planes = vcell::part_ends(scene.objects[i], scene.box); !planes.empty())
                part_ends_[i] = std::move(planes);
    }

    /// Where the parts of a tube's cell end.
    const std::vector<Plane>& part_ends(std::uint32_t object) const {
        static const std::vector<Plane> none_at_all;
        const auto at = part_ends_.find(object);
        return at == part_ends_.end() ? none_at_all : at->second;
    }
    bool has_part_ends() const { return !part_ends_.empty(); }

    bool is_periodic() const { return decided_.has_value(); }
    Vec3 place(const Vec3& unmoved_place, const Image& by) const {
        if (by == unmoved) return unmoved_place;
        return unmoved_place + decided_->balls().lattice().shift(by);
    }
    Vec3 place(const SharedPoint& p) const { return place(p.unmoved_place, p.image); }

    SharedPoint new_point(const Vec3& place) { return {next_++, unmoved, place}; }
    SharedId new_id() { return next_++; }

    /// Cells of lower objects come no more.
    void pass_to(std::uint32_t object) {
        for (; passed_ < object; ++passed_) {
            vertices.erase(passed_);
            closed_lines.erase(passed_);
            faces.erase(passed_);
        }
    }
    void has_drawn(std::uint32_t object) { has_come_[object] = true; }
    bool has_come(std::uint32_t object) const { return has_come_[object]; }
    bool may_come(std::uint32_t object) const { return object >= passed_; }

    /// Under each of its objects whose cells may come.
    template <class T, class Shared>
    void list(Lists<T>& lists, const std::shared_ptr<Shared>& what) {
        for (const NetworkSite& s : what->sites)
            if (s.site.is_object() && may_come(s.site.index)) lists[s.site.index].push_back(T{what, s.image});
    }

    Lists<ListedVertex> vertices;
    Lists<ListedLine> closed_lines;
    std::unordered_map<std::uint32_t, std::vector<std::shared_ptr<SharedFace>>>
        faces;  // by the object beyond
    std::size_t drawn_again = 0;

private:
    std::optional<whole::DecidedDiagram> decided_;  // where the box repeats
    std::unordered_map<std::uint32_t, std::vector<Plane>> part_ends_;
    std::vector<bool> has_come_;
    std::uint32_t passed_ = 0;
    SharedId next_ = 0;
};

}  // namespace vcell::shared
