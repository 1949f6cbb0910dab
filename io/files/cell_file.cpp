#include "cell_file.hpp"

#include <fmt/format.h>

#include <climits>
#include <cmath>
#include <string>
#include <utility>

#include "../solids/shell.hpp"
#include "cell_json.hpp"
#include "files.hpp"
#include "scene_json.hpp"

namespace vcell {

namespace {

void write_site(JsonWriter& out, Site site) {
    if (site.is_object())
        out.value(site.index);
    else
        out.value(to_string(site));
}

template <class Sites>
void write_sites(JsonWriter& out, const Sites& sites) {
    out.array([&] {
        for (const Site& s : sites) write_site(out, s);
    });
}

template <int Dim>
void write_curve(JsonWriter& out, const RationalCurve<Dim>& curve) {
    out.object([&] {
        out.key("degree").value(curve.degree);
        out.key("knots").value(curve.knots);
        out.key("points").value(curve.points);
    });
}

std::string error_key(const char* measure, bool is_estimated) {
    return std::string(measure) + (is_estimated ? "_error_estimate" : "_error");
}

void write_vertex(JsonWriter& out, const CellVertex& v) {
    out.object([&] {
        out.key("point").value(v.point);
        out.key("radius").value(v.radius);
        write_sites(out.key("sites"), v.sites);
        out.key("error").value(v.error);
        if (v.is_touching) out.key("touching").value(true);
    });
}

void write_edge(JsonWriter& out, const CellEdge& e) {
    out.object([&] {
        write_sites(out.key("sites"), e.sites);
        if (!e.extra_sites.empty()) write_sites(out.key("extra_sites"), e.extra_sites);
        out.key("vertices").value(e.vertices);
        out.key("kind").value(to_string(e.kind));
        out.key("error").value(e.error);
        out.key("length").value(e.length);
        out.key(error_key("length", e.is_estimated)).value(e.length_error);
        write_curve(out.key("curve"), e.curve);
    });
}

void write_closing_edge(JsonWriter& out, const CellEdge& e) {
    out.object([&] {
        write_sites(out.key("sites"), e.sites);
        out.key("vertices").value(e.vertices);
        out.key("error").value(e.error);
        write_curve(out.key("curve"), e.curve);
    });
}

void write_trim_curve(JsonWriter& out, const TrimCurve& c) {
    out.object([&] {
        out.key("edge");
        if (c.edge)
            out.value(*c.edge);
        else
            out.null();
        if (c.seam) out.key("seam").value(*c.seam);
        out.key("reversed").value(c.reversed);
        write_curve(out.key("curve"), c.curve);
    });
}

void write_interval(JsonWriter& out, const std::array<double, 2>& ends) {
    out.array([&] {
        for (const double x : ends) out.value(x);
    });
}

void write_patch(JsonWriter& out, const TrimmedPatch& patch) {
    const RationalPatch& s = patch.surface;
    out.object([&] {
        out.key("degree").array([&] {
            out.value(s.degree_u);
            out.value(s.degree_v);
        });
        out.key("domain").array([&] {
            write_interval(out, s.domain_u);
            write_interval(out, s.domain_v);
        });
        out.key("points").array([&] {
            for (int i = 0; i <= s.degree_u; ++i)
                out.array([&] {
                    for (int j = 0; j <= s.degree_v; ++j) out.value(s.point(i, j));
                });
        });
        out.key("loops").array([&] {
            for (const auto& loop : patch.loops)
                out.array([&] {
                    for (const TrimCurve& c : loop) write_trim_curve(out, c);
                });
        });
    });
}

void write_face(JsonWriter& out, const CellFace& f) {
    out.object([&] {
        write_site(out.key("site"), f.site);
        if (!f.extra_sites.empty()) write_sites(out.key("extra_sites"), f.extra_sites);
        out.key("bisector").value(f.bisector);
        out.key("area").value(f.area);
        out.key(error_key("area", f.is_estimated)).value(f.area_error);
        out.key("patches").array([&] {
            for (const TrimmedPatch& p : f.patches) write_patch(out, p);
        });
    });
}

void write_closing_face(JsonWriter& out, const CellFace& f) {
    out.object([&] {
        write_site(out.key("site"), f.site);
        out.key("bisector").value(f.bisector);
        out.key("patches").array([&] {
            for (const TrimmedPatch& p : f.patches) write_patch(out, p);
        });
    });
}

void write_closing(JsonWriter& out, const Closing& closing) {
    out.object([&] {
        out.line_key("vertices").lines(closing.vertices, 1, write_vertex);
        out.line_key("edges").lines(closing.edges, 1, write_closing_edge);
        out.line_key("faces").lines(closing.faces, 1, write_closing_face);
    });
}

void write_moments(JsonWriter& out, const Moments& m) {
    out.object([&] {
        out.key("centroid").value(m.centroid);
        out.key("centroid_error").value(m.centroid_error);
        out.key("second").array([&] {
            for (int i = 0; i < 3; ++i) out.value(Vec3(m.second.row(i)));
        });
        out.key("second_error").value(m.second_error);
    });
}

void write_measures(JsonWriter& out, const Measures& m, const std::optional<Moments>& moments) {
    out.object([&] {
        out.key("volume").value(m.volume);
        out.key(error_key("volume", m.is_estimated)).value(m.volume_error);
        out.key("body_volume").value(m.body_volume);
        out.key("body_volume_error").value(m.body_volume_error);
        out.key("area").value(m.area);
        out.key(error_key("area", m.is_estimated)).value(m.area_error);
        out.key("box_area").value(m.box_area);
        out.key(error_key("box_area", m.is_estimated)).value(m.box_area_error);
        out.key("base_area").value(m.base_area);
        out.key("base_area_error").value(m.base_area_error);
        out.key("min_clearance").value(m.min_clearance);
        out.key("min_clearance_error").value(m.min_clearance_error);
        out.key("max_clearance").value(m.max_clearance);
        out.key("max_clearance_error").value(m.max_clearance_error);
        out.key("touches_box").value(m.touches_box);
        if (moments) write_moments(out.key("moments"), *moments);
    });
}

void write_report(JsonWriter& out, const Report& r) {
    out.object([&] {
        out.key("decisions").object([&] {
            out.key("double").value(r.decisions.by_double);
            out.key("interval").value(r.decisions.by_interval);
            out.key("exact").value(r.decisions.by_exact);
            out.key("multiprecision").value(r.decisions.by_multiprecision);
            out.key("assumed").value(r.decisions.assumed);
        });
        out.key("work").object([&] {
            out.key("insertions").value(r.insertions);
            out.key("merges").value(r.merges);
            out.key("pieces").value(r.pieces);
        });
        out.key("seconds").object([&] {
            out.key("bisectors").value(r.seconds_bisectors);
            out.key("envelope").value(r.seconds_envelope);
            out.key("patches").value(r.seconds_patches);
        });
        out.key("moved").value(r.moved);
        out.key("warnings").lines(r.warnings, [&](const std::string& w) { out.value(w); });
    });
}

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

    std::pair<std::uint32_t, Cell> read_of_diagram() {
        std::uint32_t object = 0;
        read_with(required_member("object", [&] { object = index(); }));
        return {object, std::move(cell_)};
    }

private:
    using Kind = InputError::Kind;

    template <class... Members>
    void read_with(Members... members) {
        in_.object(std::move(members)...,
                   required_member("vertices", [&] { list(cell_.vertices, [&] { return vertex(); }); }),
                   required_member("edges", [&] { list(cell_.edges, [&] { return edge(); }); }),
                   required_member("faces", [&] { list(cell_.faces, [&] { return face(); }); }),
                   required_member("neighbors", [&] { list(cell_.neighbors, [&] { return index(); }); }),
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

    Site site() {
        if (in_.next_is_number()) return Site::object(index());
        if (!in_.next_is_string()) in_.fail(Kind::WrongType, "must be an object's index or a site's name");
        const std::string name = in_.string();
        std::vector<Site> named{Site::base(), Site::end(0), Site::end(1)};
        for (std::uint32_t side = 0; side < 6; ++side) named.push_back(Site::box_side(side));
        for (const Site s : named)
            if (to_string(s) == name) return s;
        in_.fail(Kind::OutOfRange, "must be \"base\", a side as \"box:-x\" or an end as \"end:+\"");
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
        in_.object(required_member("volume", [&] { m.volume = in_.number(); }),
                   error_member("volume_error", m.volume_error),
                   estimate_member("volume_error_estimate", m.volume_error, m.is_estimated),
                   required_member("body_volume", [&] { m.body_volume = in_.number(); }),
                   required_member("body_volume_error", [&] { m.body_volume_error = in_.number(); }),
                   required_member("area", [&] { m.area = in_.number(); }),
                   error_member("area_error", m.area_error),
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
                   optional_member("moments", [&] { moments(cell_.moments.emplace()); }));
        need("volume_error", m.volume_error);
        need("area_error", m.area_error);
        need("box_area_error", m.box_area_error);
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

    JsonReader& in_;
    Cell cell_;
    bool has_scene_ = false;
};

}  // namespace

namespace {

void write_elements(JsonWriter& out, const Cell& cell, const Closing* closing, unsigned threads) {
    out.line_key("vertices").lines(cell.vertices, threads, write_vertex);
    out.line_key("edges").lines(cell.edges, threads, write_edge);
    out.line_key("faces").lines(cell.faces, threads, write_face);
    if (closing) write_closing(out.line_key("closing"), *closing);
    out.line_key("neighbors").value(cell.neighbors);
    write_measures(out.line_key("measures"), cell.measures, cell.moments);
    write_report(out.line_key("report"), cell.report);
}

}  // namespace

void write_cell(std::ostream& out, const Cell& cell, unsigned threads) {
    Closing made;
    if (!cell.closing) made = closing_of(cell);
    const Closing* const closing = cell.closing ? &*cell.closing : made.faces.empty() ? nullptr : &made;
    JsonWriter writer(out);
    writer.object([&] {
        writer.key("vcell").value(format_version);
        write_scene_value(writer.line_key("scene"), cell.scene);
        if (cell.is_complete) writer.line_key("complete").value(true);
        write_elements(writer, cell, closing, threads);
    });
    writer.finish();
    out << '\n';
}

namespace {

// What a scene file has at its top and a cell has not.
bool is_key_of_scene(std::string_view path) {
    for (const std::string_view key : {"base", "objects", "base_object", "box", "units", "tolerance"})
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

void write_cell_of_diagram(JsonWriter& out, std::uint32_t object, const Cell& cell) {
    out.object([&] {
        out.key("object").value(object);
        write_elements(out, cell, nullptr, 1);
    });
}

std::pair<std::uint32_t, Cell> read_cell_of_diagram(JsonReader& in) {
    return CellReader(in).read_of_diagram();
}

Cell read_cell(const std::string& path) { return parse_cell(read_file(path)); }

}  // namespace vcell
