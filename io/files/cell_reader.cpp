#include <fmt/format.h>

#include <charconv>
#include <climits>
#include <cmath>
#include <map>
#include <string>
#include <system_error>
#include <utility>

#include "cell_file.hpp"
#include "cell_json.hpp"
#include "files.hpp"
#include "scene_json.hpp"

namespace vcell {

namespace {

class CellReader {
public:
    explicit CellReader(JsonReader& in) : in_(in) {}

    Cell read() {
        read_with(required_member("vcell", [&] { read_format_version(in_); }),
                  required_member("scene",
                                  [&] {
                                      has_scene_ = true;
                                      cell_.scene = read_scene_value(in_);
                                  }),
                  optional_member("complete", [&] { cell_.is_complete = in_.boolean(); }),
                  optional_member("closing", [&] { closing(cell_.closing.emplace()); }));
        in_.end();
        return std::move(cell_);
    }

    bool has_scene() const { return has_scene_; }

    CellOfDiagram read_of_diagram() {
        CellOfDiagram result;
        places_.emplace();
        read_with(required_member("object", [&] { result.object = index(); }),
                  optional_member("side",
                                  [&] {
                                      const std::string side = in_.string();
                                      if (side != "+" && side != "-")
                                          in_.fail(Kind::OutOfRange, "must be \"+\" or \"-\"");
                                      result.side = side == "+";
                                  }),
                  optional_member("box", [&] { result.box = read_box(in_); }),
                  optional_member("complete", [&] { cell_.is_complete = in_.boolean(); }));
        sort_images();
        result.cell = std::move(cell_);
        return result;
    }

private:
    using Kind = InputError::Kind;

    template <class... Members>
    void read_with(Members... members) {
        in_.object(std::move(members)...,
                   required_member("vertices", [&] { list(cell_.vertices, [&] { return vertex(); }); }),
                   required_member("edges", [&] { list(cell_.edges, [&] { return edge(); }); }),
                   required_member("faces", [&] { list(cell_.faces, [&] { return face(); }); }),
                   optional_member("parts", [&] { list(cell_.parts, [&] { return part(); }); }),
                   required_member("neighbors", [&] { list(cell_.neighbors, [&] { return neighbor(); }); }),
                   required_member("measures", [&] { measures(cell_.measures); }),
                   required_member("report", [&] { report(cell_.report); }));
    }

    template <class Items, class F>
    void list(Items& items, F item) {
        in_.array([&](std::size_t) { items.push_back(item()); });
    }

    // A bound, or under a name that says so an estimate: one of them is needed.
    auto error_member(std::string_view key, double& value) {
        return optional_member(key, [this, &value] { value = in_.number(); });
    }
    auto estimate_member(std::string_view key, double& value, bool& is_estimated) {
        return optional_member(key, [this, &value, &is_estimated] {
            value = in_.number();
            is_estimated = true;
        });
    }
    void need(std::string_view key, double value) {
        if (std::isnan(value)) in_.fail_missing(key);
    }

    std::uint32_t index() { return static_cast<std::uint32_t>(in_.unsigned_integer(UINT32_MAX - 1)); }

    int degree() { return static_cast<int>(in_.unsigned_integer(INT_MAX - 1)); }

    // A diagram's cell numbers the objects in the order in which it names them, as it has no scene.
    std::uint32_t place_of(const ObjectImage& object) {
        const auto next = static_cast<std::uint32_t>(places_->size());
        return places_->try_emplace(object, next).first->second;
    }
    // "3(0,-1,0)"
    std::optional<ObjectImage> image(const std::string& name) const {
        ObjectImage object;
        const char *at = name.data(), *const end = at + name.size();
        const auto read = [&](auto& number, char before) {
            if (before != 0 && (at == end || *at++ != before)) return false;
            const auto [after, error] = std::from_chars(at, end, number);
            at = after;
            return error == std::errc();
        };
        if (!read(object.number, 0) || !read(object.image[0], '(') || !read(object.image[1], ',') ||
            !read(object.image[2], ',') || object.number == UINT32_MAX || to_string(object) != name)
            return std::nullopt;
        return object;
    }
    std::uint32_t neighbor() {
        if (!places_ || in_.next_is_number()) return object_site();
        if (!in_.next_is_string()) in_.fail(Kind::WrongType, "must be an object's number or an image of it");
        const auto object = image(in_.string());
        if (!object) in_.fail(Kind::OutOfRange, "must be an image of an object, as \"3(0,-1,0)\"");
        return place_of(*object);
    }
    std::uint32_t object_site() {
        const std::uint32_t number = index();
        return places_ ? place_of({number}) : number;
    }

    Site site() {
        if (in_.next_is_number()) return Site::object(object_site());
        if (!in_.next_is_string()) in_.fail(Kind::WrongType, "must be an object's index or a site's name");
        const std::string name = in_.string();
        if (places_)
            if (const auto object = image(name)) return Site::object(place_of(*object));
        std::vector<Site> named{Site::base(), Site::end(0), Site::end(1), Site::cap()};
        for (std::uint32_t side = 0; side < 6; ++side) named.push_back(Site::box_side(side));
        for (const Site s : named)
            if (to_string(s) == name) return s;
        in_.fail(Kind::OutOfRange, "must be \"base\", \"cap\", a side as \"box:-x\" or an end as \"end:+\"");
    }

    CurveKind curve_kind() {
        const std::string name = in_.string();
        for (const CurveKind k : {CurveKind::Line, CurveKind::Circle, CurveKind::Ellipse, CurveKind::Parabola,
                                  CurveKind::Hyperbola, CurveKind::Spline})
            if (to_string(k) == name) return k;
        in_.fail(Kind::OutOfRange, "must be line, circle, ellipse, parabola, hyperbola or spline");
    }

    template <int N>
    Eigen::Matrix<double, N, 1> control_point() {
        Eigen::Matrix<double, N, 1> p;
        in_.array_of(N, [&](std::size_t i) { p[static_cast<Eigen::Index>(i)] = in_.number(); });
        return p;
    }

    template <int Dim>
    RationalCurve<Dim> curve() {
        RationalCurve<Dim> c;
        in_.object(
            required_member("degree", [&] { c.degree = degree(); }),
            required_member("knots", [&] { list(c.knots, [&] { return in_.number(); }); }),
            required_member("points", [&] { list(c.points, [&] { return control_point<Dim + 1>(); }); }));
        return c;
    }

    CellVertex vertex() {
        CellVertex v;
        in_.object(required_member("point", [&] { v.point = read_vec3(in_); }),
                   required_member("radius", [&] { v.radius = in_.number(); }),
                   required_member("sites", [&] { list(v.sites, [&] { return site(); }); }),
                   required_member("error", [&] { v.error = in_.number(); }),
                   optional_member("touching", [&] { v.is_touching = in_.boolean(); }));
        return v;
    }

    CellEdge edge() {
        CellEdge e;
        in_.object(
            required_member("sites", [&] { in_.array_of(2, [&](std::size_t i) { e.sites[i] = site(); }); }),
            optional_member("extra_sites", [&] { list(e.extra_sites, [&] { return site(); }); }),
            required_member("vertices", [&] { list(e.vertices, [&] { return index(); }); }),
            required_member("kind", [&] { e.kind = curve_kind(); }),
            required_member("error", [&] { e.error = in_.number(); }),
            required_member("length", [&] { e.length = in_.number(); }),
            error_member("length_error", e.length_error),
            estimate_member("length_error_estimate", e.length_error, e.is_estimated),
            required_member("curve", [&] { e.curve = curve<3>(); }));
        need("length_error", e.length_error);
        return e;
    }

    TrimCurve trim_curve() {
        TrimCurve c;
        in_.object(required_member("edge",
                                   [&] {
                                       if (!in_.null()) c.edge = index();
                                   }),
                   optional_member("seam", [&] { c.seam = index(); }),
                   required_member("reversed", [&] { c.reversed = in_.boolean(); }),
                   required_member("curve", [&] { c.curve = curve<2>(); }));
        return c;
    }

    std::array<double, 2> interval() {
        std::array<double, 2> ends{};
        in_.array_of(2, [&](std::size_t i) { ends[i] = in_.number(); });
        return ends;
    }

    TrimmedPatch patch() {
        TrimmedPatch p;
        RationalPatch& s = p.surface;
        std::vector<std::size_t> row_sizes;
        in_.object(required_member("degree",
                                   [&] {
                                       in_.array_of(2, [&](std::size_t i) {
                                           (i == 0 ? s.degree_u : s.degree_v) = degree();
                                       });
                                   }),
                   required_member("domain",
                                   [&] {
                                       in_.array_of(2, [&](std::size_t i) {
                                           (i == 0 ? s.domain_u : s.domain_v) = interval();
                                       });
                                   }),
                   required_member("points",
                                   [&] {
                                       in_.array([&](std::size_t) {
                                           const std::size_t before = s.points.size();
                                           list(s.points, [&] { return control_point<4>(); });
                                           row_sizes.push_back(s.points.size() - before);
                                       });
                                   }),
                   required_member("loops", [&] {
                       list(p.loops, [&] {
                           std::vector<TrimCurve> loop;
                           list(loop, [&] { return trim_curve(); });
                           return loop;
                       });
                   }));
        bool complete = row_sizes.size() == static_cast<std::size_t>(s.degree_u) + 1;
        for (const std::size_t n : row_sizes)
            complete = complete && n == static_cast<std::size_t>(s.degree_v) + 1;
        if (!complete)
            in_.fail(Kind::OutOfRange, fmt::format("points must be {} rows of {} by the degree",
                                                   s.degree_u + 1, s.degree_v + 1));
        return p;
    }

    CellFace face() {
        CellFace f;
        in_.object(required_member("site", [&] { f.site = site(); }),
                   optional_member("extra_sites", [&] { list(f.extra_sites, [&] { return site(); }); }),
                   required_member("bisector", [&] { f.bisector = in_.string(); }),
                   required_member("area", [&] { f.area = in_.number(); }),
                   error_member("area_error", f.area_error),
                   estimate_member("area_error_estimate", f.area_error, f.is_estimated),
                   required_member("patches", [&] { list(f.patches, [&] { return patch(); }); }));
        need("area_error", f.area_error);
        return f;
    }

    CellPart part() {
        CellPart p;
        in_.object(required_member(
                       "ends", [&] { in_.array_of(2, [&](std::size_t i) { p.ends[i] = read_vec3(in_); }); }),
                   required_member("faces", [&] { p.faces = index(); }));
        return p;
    }

    CellEdge closing_edge() {
        CellEdge e;
        in_.object(
            required_member("sites", [&] { in_.array_of(2, [&](std::size_t i) { e.sites[i] = site(); }); }),
            required_member("vertices", [&] { list(e.vertices, [&] { return index(); }); }),
            required_member("error", [&] { e.error = in_.number(); }),
            required_member("curve", [&] { e.curve = curve<3>(); }));
        return e;
    }

    CellFace closing_face() {
        CellFace f;
        in_.object(required_member("site", [&] { f.site = site(); }),
                   required_member("bisector", [&] { f.bisector = in_.string(); }),
                   required_member("patches", [&] { list(f.patches, [&] { return patch(); }); }));
        return f;
    }

    void closing(Closing& c) {
        in_.object(required_member("vertices", [&] { list(c.vertices, [&] { return vertex(); }); }),
                   required_member("edges", [&] { list(c.edges, [&] { return closing_edge(); }); }),
                   required_member("faces", [&] { list(c.faces, [&] { return closing_face(); }); }));
    }

    void measures(Measures& m) {
        in_.object(
            required_member("volume", [&] { m.volume = in_.number(); }),
            error_member("volume_error", m.volume_error),
            estimate_member("volume_error_estimate", m.volume_error, m.is_estimated),
            required_member("body_volume", [&] { m.body_volume = in_.number(); }),
            required_member("body_volume_error", [&] { m.body_volume_error = in_.number(); }),
            required_member("area", [&] { m.area = in_.number(); }), error_member("area_error", m.area_error),
            estimate_member("area_error_estimate", m.area_error, m.is_estimated),
            required_member("box_area", [&] { m.box_area = in_.number(); }),
            error_member("box_area_error", m.box_area_error),
            estimate_member("box_area_error_estimate", m.box_area_error, m.is_estimated),
            required_member("base_area", [&] { m.base_area = in_.number(); }),
            required_member("base_area_error", [&] { m.base_area_error = in_.number(); }),
            required_member("min_clearance", [&] { m.min_clearance = in_.number(); }),
            required_member("min_clearance_error", [&] { m.min_clearance_error = in_.number(); }),
            required_member("max_clearance", [&] { m.max_clearance = in_.number(); }),
            required_member("max_clearance_error", [&] { m.max_clearance_error = in_.number(); }),
            required_member("touches_box", [&] { m.touches_box = in_.boolean(); }),
            optional_member("min_clearance_place", [&] { clearance_place(&ClearancePlaces::least); }),
            optional_member("max_clearance_place", [&] { clearance_place(&ClearancePlaces::greatest); }),
            optional_member("moments", [&] { moments(cell_.moments.emplace()); }));
        need("volume_error", m.volume_error);
        need("area_error", m.area_error);
        need("box_area_error", m.box_area_error);
    }

    void clearance_place(std::optional<ClearancePlace> ClearancePlaces::*which) {
        if (!cell_.clearance_places) cell_.clearance_places.emplace();
        ClearancePlace& place = ((*cell_.clearance_places).*which).emplace();
        in_.object(required_member("point", [&] { place.point = read_vec3(in_); }),
                   required_member("error", [&] { place.error = in_.number(); }),
                   required_member("clearance", [&] { place.clearance = in_.number(); }),
                   required_member("clearance_error", [&] { place.clearance_error = in_.number(); }),
                   required_member("sites", [&] { list(place.sites, [&] { return site(); }); }),
                   optional_member("vertex", [&] { place.vertex = index(); }),
                   optional_member("edge", [&] { place.edge = index(); }),
                   optional_member("face", [&] { place.face = index(); }));
    }

    void moments(Moments& m) {
        in_.object(required_member("centroid", [&] { m.centroid = read_vec3(in_); }),
                   required_member("centroid_error", [&] { m.centroid_error = in_.number(); }),
                   required_member("second",
                                   [&] {
                                       in_.array_of(3, [&](std::size_t i) {
                                           m.second.row(static_cast<Eigen::Index>(i)) =
                                               read_vec3(in_).transpose();
                                       });
                                   }),
                   required_member("second_error", [&] { m.second_error = in_.number(); }));
    }

    void report(Report& r) {
        Decisions& d = r.decisions;
        in_.object(
            required_member(
                "decisions",
                [&] {
                    in_.object(required_member("double", [&] { d.by_double = in_.unsigned_integer(); }),
                               required_member("interval", [&] { d.by_interval = in_.unsigned_integer(); }),
                               required_member("exact", [&] { d.by_exact = in_.unsigned_integer(); }),
                               required_member("multiprecision",
                                               [&] { d.by_multiprecision = in_.unsigned_integer(); }),
                               required_member("assumed", [&] { d.assumed = in_.unsigned_integer(); }));
                }),
            required_member(
                "work",
                [&] {
                    in_.object(required_member("insertions", [&] { r.insertions = in_.unsigned_integer(); }),
                               required_member("merges", [&] { r.merges = in_.unsigned_integer(); }),
                               required_member("pieces", [&] { r.pieces = in_.unsigned_integer(); }));
                }),
            required_member("seconds",
                            [&] {
                                in_.object(
                                    required_member("bisectors", [&] { r.seconds_bisectors = in_.number(); }),
                                    required_member("envelope", [&] { r.seconds_envelope = in_.number(); }),
                                    required_member("patches", [&] { r.seconds_patches = in_.number(); }));
                            }),
            required_member("moved", [&] { r.moved = in_.number(); }),
            required_member("warnings", [&] { list(r.warnings, [&] { return in_.string(); }); }));
    }

    // Places ascend as the images do.
    void sort_images() {
        std::vector<std::uint32_t> sorted(places_->size());
        for (const auto& [object, place] : *places_) {
            sorted[place] = static_cast<std::uint32_t>(cell_.scene.images.size());
            cell_.scene.images.push_back(object);
        }
        for_each_site(cell_, [&](Site& site) {
            if (site.is_object()) site.index = sorted[site.index];
        });
        for (std::uint32_t& n : cell_.neighbors) n = sorted[n];
    }

    JsonReader& in_;
    Cell cell_;
    bool has_scene_ = false;
    std::optional<std::map<ObjectImage, std::uint32_t>> places_;  // of a cell of a diagram
};

}  // namespace

namespace {

// What a scene file has at its top and a cell has not.
bool is_key_of_scene(std::string_view path) {
    for (const std::string_view key :
         {"base", "objects", "base_object", "box", "units", "tolerance", "probe"})
        if (path == key) return true;
    return false;
}

}  // namespace

Cell parse_cell(std::string_view text) {
    Cell cell = [&] {
        try {
            JsonReader in(text);
            return CellReader(in).read();
        } catch (const InputError& e) {
            if (e.kind != InputError::Kind::UnknownKey || !is_key_of_scene(e.path)) throw;
            throw InputError(InputError::Kind::WrongType, InputError::no_object, "",
                             "this is a scene, not a cell: \"vcell compute\" makes its cell");
        }
    }();
    validate(cell.scene);
    return cell;
}

std::optional<Cell> parse_if_cell(std::string_view text) {
    std::optional<Cell> cell;
    JsonReader in(text);
    CellReader reader(in);
    try {
        cell = reader.read();
    } catch (const InputError&) {
        if (reader.has_scene()) throw;
        return std::nullopt;
    }
    validate(cell->scene);
    return cell;
}

CellOfDiagram read_cell_of_diagram(JsonReader& in) { return CellReader(in).read_of_diagram(); }

Cell read_cell(const std::string& path) { return parse_cell(read_file(path)); }

}  // namespace vcell
