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

#include "../../envelope/whole/image_tree.hpp"
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

/// What has been stored, or changed, since somebody asked for it: whole vertices, with all their lines.
struct Additions {
    std::uint32_t object = 0;  ///< whose cell has been drawn
    std::vector<std::shared_ptr<SharedVertex>> vertices;
    std::vector<std::shared_ptr<SharedLine>> closed_lines;
    std::vector<std::shared_ptr<SharedFace>> faces;
};

/// Everything that cells so far have drawn and others may have, too. Cells that have anything in common come
/// in the order of their objects.
class Store {
public:
    /// The scene has so many objects; its lattice is none where the box does not repeat, and `part_ends`
    /// tells where the parts of tubes' cells end.
    Store(std::optional<whole::Lattice> lattice,
          std::unordered_map<std::uint32_t, std::vector<Plane>> part_ends, std::size_t objects)
        : lattice_(std::move(lattice)), part_ends_(std::move(part_ends)), has_come_(objects, false) {}

    /// Where the parts of a tube's cell end.
    const std::vector<Plane>& part_ends(std::uint32_t object) const {
        static const std::vector<Plane> none_at_all;
        const auto at = part_ends_.find(object);
        return at == part_ends_.end() ? none_at_all : at->second;
    }
    bool has_part_ends() const { return !part_ends_.empty(); }

    bool is_periodic() const { return lattice_.has_value(); }
    Vec3 place(const Vec3& unmoved_place, const Image& by) const {
        return by == unmoved ? unmoved_place : Vec3(unmoved_place + lattice_->shift(by));
    }
    Vec3 place(const SharedPoint& p) const { return place(p.unmoved_place, p.image); }

    // Numbers ascend as they would if all cells were drawn in the order of their objects.
    SharedPoint new_point(const Vec3& place) { return {new_id(), unmoved, place}; }
    SharedId new_id() { return SharedId{current_} << 32 | next_++; }

    /// A cell of that object is drawn: of what it has in common with others these have the higher numbers, or
    /// have come.
    void begin(std::uint32_t object) {
        if (object != current_) next_ = 0;
        current_ = object;
    }
    bool may_come(std::uint32_t object) const { return object >= current_; }
    void has_drawn(std::uint32_t object) { has_come_[object] = true; }
    bool has_come(std::uint32_t object) const { return has_come_[object]; }
    /// No cell of the object comes any more.
    void forget(std::uint32_t object) {
        vertices.erase(object);
        closed_lines.erase(object);
        faces.erase(object);
    }

    void add(const std::shared_ptr<SharedVertex>& vertex) {
        list(vertices, vertex);
        note(vertex);
    }
    void add(const std::shared_ptr<SharedLine>& closed_line) {
        list(closed_lines, closed_line);
        if (is_noting_) added_.closed_lines.push_back(closed_line);
    }
    void add(const std::shared_ptr<SharedFace>& face) {
        faces[face->beyond.site.index].push_back(face);
        if (is_noting_) added_.faces.push_back(face);
    }
    void add_site(const std::shared_ptr<SharedVertex>& vertex, const NetworkSite& site) {
        vertex->sites.insert(std::ranges::upper_bound(vertex->sites, site), site);
        if (site.site.is_object() && may_come(site.site.index))
            vertices[site.site.index].push_back({vertex, site.image});
        note(vertex);
    }
    void add_line(const std::shared_ptr<SharedVertex>& vertex, std::shared_ptr<SharedLine> line) {
        vertex->lines.push_back(std::move(line));
        note(vertex);
    }

    /// From now on additions are noted.
    void note_additions() { is_noting_ = true; }
    /// Returns what was noted since the last call.
    Additions take_additions() {
        std::ranges::sort(added_.vertices, {}, [](const auto& v) { return v->point.id; });
        added_.vertices.erase(std::ranges::unique(added_.vertices).begin(), added_.vertices.end());
        added_.object = current_;
        return std::exchange(added_, {});
    }
    /// Takes over what a store elsewhere has noted; it is this store's from now on.
    void learn(const Additions& additions) {
        begin(additions.object);
        const bool was_noting = std::exchange(is_noting_, false);
        for (const auto& vertex : additions.vertices) learn(vertex);
        is_noting_ = was_noting;
        for (const auto& line : additions.closed_lines) list(closed_lines, line);
        for (const auto& face : additions.faces) faces[face->beyond.site.index].push_back(face);
        has_drawn(additions.object);
    }

    Lists<ListedVertex> vertices;
    Lists<ListedLine> closed_lines;
    std::unordered_map<std::uint32_t, std::vector<std::shared_ptr<SharedFace>>>
        faces;  // by the object beyond
    std::size_t drawn_again = 0;

private:
    // Under each of its objects whose cells may come.
    template <class T, class Shared>
    void list(Lists<T>& lists, const std::shared_ptr<Shared>& what) {
        for (const NetworkSite& s : what->sites)
            if (s.site.is_object() && may_come(s.site.index)) lists[s.site.index].push_back(T{what, s.image});
    }
    void note(const std::shared_ptr<SharedVertex>& vertex) {
        if (is_noting_) added_.vertices.push_back(vertex);
    }
    void learn(const std::shared_ptr<SharedVertex>& vertex) {
        const std::shared_ptr<SharedVertex> known = stored(*vertex);
        if (!known) return list(vertices, vertex);
        for (const NetworkSite& s : vertex->sites)
            if (!std::ranges::binary_search(known->sites, s)) add_site(known, s);
        for (const auto& line : vertex->lines)
            if (std::ranges::none_of(known->lines, [&](const auto& l) { return l->id == line->id; }))
                known->lines.push_back(line);
    }
    std::shared_ptr<SharedVertex> stored(const SharedVertex& vertex) const {
        for (const NetworkSite& s : vertex.sites) {
            const auto list = s.site.is_object() ? vertices.find(s.site.index) : vertices.end();
            if (list == vertices.end()) continue;
            for (const ListedVertex& listed : list->second)
                if (listed.what->point.id == vertex.point.id) return listed.what;
        }
        return nullptr;
    }

    std::optional<whole::Lattice> lattice_;
    std::unordered_map<std::uint32_t, std::vector<Plane>> part_ends_;
    std::vector<bool> has_come_;
    std::uint32_t current_ = 0, next_ = 0;
    bool is_noting_ = false;
    Additions added_;
};

}  // namespace vcell::shared
