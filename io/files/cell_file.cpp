#include "cell_file.hpp"

#include <optional>
#include <span>
#include <string>

#include "../solids/shell.hpp"
#include "cell_json.hpp"
#include "scene_json.hpp"

namespace vcell {

namespace {

// What sites are that are places in a box that repeats; nothing where they are numbers.
using Images = std::span<const ObjectImage>;

void write_site(JsonWriter& out, Site site, Images images) {
    if (!site.is_object())
        out.value(to_string(site));
    else if (images.empty())
        out.value(site.index);
    else if (const ObjectImage& object = images[site.index]; object.image == ObjectImage{}.image)
        out.value(object.number);
    else
        out.value(to_string(object));
}

template <class Sites>
void write_sites(JsonWriter& out, const Sites& sites, Images images) {
    out.array([&] {
        for (const Site& s : sites) write_site(out, s, images);
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

void write_vertex(JsonWriter& out, const CellVertex& v, Images images) {
    out.object([&] {
        out.key("point").value(v.point);
        out.key("radius").value(v.radius);
        write_sites(out.key("sites"), v.sites, images);
        out.key("error").value(v.error);
        if (v.is_touching) out.key("touching").value(true);
    });
}

void write_edge(JsonWriter& out, const CellEdge& e, Images images) {
    out.object([&] {
        write_sites(out.key("sites"), e.sites, images);
        if (!e.extra_sites.empty()) write_sites(out.key("extra_sites"), e.extra_sites, images);
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
        write_sites(out.key("sites"), e.sites, {});
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

void write_face(JsonWriter& out, const CellFace& f, Images images) {
    out.object([&] {
        write_site(out.key("site"), f.site, images);
        if (!f.extra_sites.empty()) write_sites(out.key("extra_sites"), f.extra_sites, images);
        out.key("bisector").value(f.bisector);
        out.key("area").value(f.area);
        out.key(error_key("area", f.is_estimated)).value(f.area_error);
        out.key("patches").array([&] {
            for (const TrimmedPatch& p : f.patches) write_patch(out, p);
        });
    });
}

void write_part(JsonWriter& out, const CellPart& part) {
    out.object([&] {
        out.key("ends").array([&] {
            for (const Vec3& end : part.ends) out.value(end);
        });
        out.key("faces").value(part.faces);
    });
}

void write_closing_face(JsonWriter& out, const CellFace& f) {
    out.object([&] {
        write_site(out.key("site"), f.site, {});
        out.key("bisector").value(f.bisector);
        out.key("patches").array([&] {
            for (const TrimmedPatch& p : f.patches) write_patch(out, p);
        });
    });
}

void write_closing(JsonWriter& out, const Closing& closing) {
    out.object([&] {
        out.line_key("vertices").lines(closing.vertices, 1, [](JsonWriter& part, const CellVertex& v) {
            write_vertex(part, v, {});
        });
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

void write_clearance_place(JsonWriter& out, const ClearancePlace& place, Images images) {
    out.object([&] {
        out.key("point").value(place.point);
        out.key("error").value(place.error);
        out.key("clearance").value(place.clearance);
        out.key("clearance_error").value(place.clearance_error);
        write_sites(out.key("sites"), place.sites, images);
        if (place.vertex) out.key("vertex").value(*place.vertex);
        if (place.edge) out.key("edge").value(*place.edge);
        if (place.face) out.key("face").value(*place.face);
    });
}

void write_measures(JsonWriter& out, const Cell& cell, Images images) {
    const Measures& m = cell.measures;
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
        if (cell.clearance_places) {
            const auto& [least, greatest] = *cell.clearance_places;
            if (least) write_clearance_place(out.key("min_clearance_place"), *least, images);
            if (greatest) write_clearance_place(out.key("max_clearance_place"), *greatest, images);
        }
        if (cell.moments) write_moments(out.key("moments"), *cell.moments);
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

void write_elements(JsonWriter& out, const Cell& cell, Images images, const Closing* closing,
                    unsigned threads) {
    const auto with_images = [images](const auto& write) {
        return [images, write](JsonWriter& part, const auto& element) { write(part, element, images); };
    };
    out.line_key("vertices").lines(cell.vertices, threads, with_images(write_vertex));
    out.line_key("edges").lines(cell.edges, threads, with_images(write_edge));
    out.line_key("faces").lines(cell.faces, threads, with_images(write_face));
    if (!cell.parts.empty()) out.line_key("parts").lines(cell.parts, 1, write_part);
    if (closing) write_closing(out.line_key("closing"), *closing);
    out.line_key("neighbors").array([&] {
        for (const std::uint32_t n : cell.neighbors) write_site(out, Site::object(n), images);
    });
    write_measures(out.line_key("measures"), cell, images);
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
        write_elements(writer, cell, {}, closing, threads);
    });
    writer.finish();
    out << '\n';
}

void write_cell_of_diagram(JsonWriter& out, std::uint32_t object, std::optional<bool> side,
                           std::optional<Box> box, const Cell& cell) {
    out.object([&] {
        out.key("object").value(object);
        if (side) out.key("side").value(std::string(*side ? "+" : "-"));
        if (box)
            out.key("box").object([&] {
                out.key("min").value(box->min);
                out.key("max").value(box->max);
            });
        if (cell.is_complete) out.key("complete").value(true);
        write_elements(out, cell, cell.scene.images, nullptr, 1);
    });
}

}  // namespace vcell
