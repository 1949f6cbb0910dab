#include "step_file.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "../../envelope/whole/void_network.hpp"
#include "../pictures/mesh.hpp"
#include "../pictures/site_style.hpp"
#include "../solids/joined_parts.hpp"
#include "../solids/solid.hpp"
#include "../solids/spline_surface.hpp"
#include "text.hpp"

namespace vcell {

namespace {

// A number as STEP has it: always with a point.
std::string real(double x) {
    std::string text = fmt::format("{}", x);
    const std::size_t e = text.find('e');
    if (text.find('.') == text.npos) text.insert(std::min(e, text.size()), ".");
    std::ranges::replace(text, 'e', 'E');
    return text;
}

template <class Values>
std::string reals(const Values& values) {
    std::vector<std::string> texts;
    for (const double x : values) texts.push_back(real(x));
    return fmt::format("({})", fmt::join(texts, ","));
}

std::string references(const std::vector<int>& ids) {
    std::vector<std::string> texts;
    for (const int id : ids) texts.push_back(fmt::format("#{}", id));
    return fmt::format("({})", fmt::join(texts, ","));
}

std::string_view flag(bool is) { return is ? ".T." : ".F."; }

// Different knots, and how often each is there.
template <class Knots>
std::pair<std::vector<double>, std::vector<int>> counted(const Knots& all) {
    std::pair<std::vector<double>, std::vector<int>> result;
    for (const double knot : all) {
        if (result.first.empty() || knot != result.first.back()) {
            result.first.push_back(knot);
            result.second.push_back(0);
        }
        ++result.second.back();
    }
    return result;
}

// A name as STEP has it in quotes (ISO 10303-21, 6.4.3): what is not ASCII in UCS, and U+FFFD for broken
// UTF-8.
std::string quoted(std::string_view name) {
    std::string text = "'";
    for (std::size_t i = 0; i < name.size();) {
        const std::size_t length = utf8_length(name.substr(i));
        const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(name[i + k]); };
        if (length == 1 && byte(0) >= ' ' && byte(0) < 0x7F) {
            text += name[i];
            if (name[i] == '\'' || name[i] == '\\') text += name[i];
        } else {
            unsigned c = length == 0 ? 0xFFFD : length == 1 ? byte(0) : byte(0) & (0x7F >> length);
            for (std::size_t k = 1; k < length; ++k) c = c << 6 | (byte(k) & 0x3F);
            text += c > 0xFFFF ? fmt::format("\\X4\\{:08X}\\X0\\", c) : fmt::format("\\X2\\{:04X}\\X0\\", c);
        }
        i += std::max<std::size_t>(length, 1);
    }
    return text + "'";
}

}  // namespace

namespace step {

// A prefix of the metre, and its millimetres.
struct Unit {
    std::string_view prefix;
    double millimetres;
};

// "m" has no prefix, and what is not known is taken for mm.
static Unit unit_of(std::string_view units) {
    constexpr Unit millimetre{".MILLI.", 1}, micrometre{".MICRO.", 1e-3};
    constexpr std::array<std::pair<std::string_view, Unit>, 5> known{{{"m", {"$", 1e3}},
                                                                      {"cm", {".CENTI.", 10}},
                                                                      {"um", micrometre},
                                                                      {"\u00b5m", micrometre},
                                                                      {"nm", {".NANO.", 1e-6}}}};
    const auto unit = std::ranges::find(known, units, [](const auto& k) { return k.first; });
    return unit == known.end() ? millimetre : unit->second;
}

// The lines of a file, numbered as they are written.
class Lines {
public:
    explicit Lines(std::ostream& out) : out_(out) {}

    template <class... Args>
    int add(fmt::format_string<Args...> format, Args&&... args) {
        fmt::print(out_, "#{}=", ++last_);
        fmt::print(out_, format, std::forward<Args>(args)...);
        out_ << ";\n";
        return last_;
    }

    template <class Point>
    int point(const Point& p) {
        return add("CARTESIAN_POINT('',{})", reals(p));
    }

    template <int Dim>
    int curve(const RationalCurve<Dim>& c) {
        std::vector<int> poles;
        std::vector<double> weights;
        for (const auto& p : c.points) {
            poles.push_back(point(Eigen::Matrix<double, Dim, 1>(p.template head<Dim>())));
            weights.push_back(p[Dim]);
        }
        const auto [knots, times] = counted(c.knots);
        return add(
            "(BOUNDED_CURVE() B_SPLINE_CURVE({},{},.UNSPECIFIED.,.F.,.F.) "
            "B_SPLINE_CURVE_WITH_KNOTS(({}),{},.UNSPECIFIED.) CURVE() GEOMETRIC_REPRESENTATION_ITEM() "
            "RATIONAL_B_SPLINE_CURVE({}) REPRESENTATION_ITEM(''))",
            c.degree, references(poles), fmt::join(times, ","), reals(knots), reals(weights));
    }

    int surface(const RationalPatch& patch, double accuracy) {
        const SplineSurface s = with_knots(patch, accuracy);
        std::vector<std::string> poles, weights;
        for (const auto& along_v : s.points) {
            std::vector<int> row;
            std::vector<double> weight_row;
            for (const Eigen::Vector4d& p : along_v) {
                row.push_back(point(Vec3(p.head<3>())));
                weight_row.push_back(p[3]);
            }
            poles.push_back(references(row));
            weights.push_back(reals(weight_row));
        }
        const auto [in_u, times_u] = counted(s.knots_u);
        const auto [in_v, times_v] = counted(s.knots_v);
        return add(
            "(BOUNDED_SURFACE() B_SPLINE_SURFACE({},{},({}),.UNSPECIFIED.,.F.,.F.,.F.) "
            "B_SPLINE_SURFACE_WITH_KNOTS(({}),({}),{},{},.UNSPECIFIED.) "
            "GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_SURFACE(({})) REPRESENTATION_ITEM('') "
            "SURFACE())",
            s.degree_u, s.degree_v, fmt::join(poles, ","), fmt::join(times_u, ","), fmt::join(times_v, ","),
            reals(in_u), reals(in_v), fmt::join(weights, ","));
    }

    // With the patch's parameters: lengths from where both are 0.
    int plane(const Solid::Face& f) {
        const auto [x, y] = f.surface.partials(0, 0);
        return add("PLANE('',#{})", add("AXIS2_PLACEMENT_3D('',#{},#{},#{})", point(f.surface.evaluate(0, 0)),
                                        direction(x.cross(y)), direction(x)));
    }

    int direction(const Vec3& d) { return add("DIRECTION('',{})", reals(d)); }

    // A solid's or a face's.
    int style(int of, std::string_view colour) {
        const std::array<int, 3> rgb = channels(colour);
        const int c =
            add("COLOUR_RGB('',{},{},{})", real(rgb[0] / 255.0), real(rgb[1] / 255.0), real(rgb[2] / 255.0));
        const int fill = add("FILL_AREA_STYLE('',(#{}))", add("FILL_AREA_STYLE_COLOUR('',#{})", c));
        const int side = add("SURFACE_SIDE_STYLE('',(#{}))", add("SURFACE_STYLE_FILL_AREA(#{})", fill));
        const int assignment =
            add("PRESENTATION_STYLE_ASSIGNMENT((#{}))", add("SURFACE_STYLE_USAGE(.BOTH.,#{})", side));
        return add("STYLED_ITEM('',(#{}),#{})", assignment, of);
    }

private:
    std::ostream& out_;
    int last_ = 0;
};

// What a cell is as a solid: all of it is known before a line of it is written.
class CellSolid {
public:
    CellSolid(const Cell& cell, double least_uncertainty)
        : joined_(joined_parts(cell)),
          shell_(closed_shell(joined_.cell)),
          solid_(solid_of(shell_, joined_.cell.faces.size(), shortest(least_uncertainty))) {}

    double off() const { return solid_.off; }

    struct Written {
        std::vector<int> solids, styled;
    };
    // Solids have that colour, or without one each face that of its site.
    Written write(Lines& out, std::string_view name, std::optional<std::string_view> colour) const {
        const double accurate = accuracy();
        std::vector<int> vertices, surfaces;
        for (const Vec3& v : solid_.vertices)
            vertices.push_back(out.add("VERTEX_POINT('',#{})", out.point(v)));
        for (const Solid::Face& f : solid_.faces)
            surfaces.push_back(f.is_flat ? out.plane(f) : out.surface(f.surface, accurate));
        const std::vector<int> edges = write_edges(out, vertices, surfaces);
        const auto colours =
            colour ? std::unordered_map<std::uint32_t, std::size_t>() : object_colours(joined_.cell);
        Written lines;
        for (const std::vector<std::uint32_t>& part : solid_.parts) {
            std::vector<int> faces;
            for (const std::uint32_t f : part) {
                faces.push_back(write_face(out, f, edges, surfaces[f]));
                const Site site = shell_.faces[solid_.faces[f].of].site;
                if (!colour)
                    lines.styled.push_back(out.style(faces.back(), site.is_object()
                                                                       ? palette()[colours.at(site.index)]
                                                                       : std::string_view("#dddddd")));
            }
            const int shell = out.add("CLOSED_SHELL('',{})", references(faces));
            lines.solids.push_back(out.add("MANIFOLD_SOLID_BREP({},#{})", quoted(name), shell));
            if (colour) lines.styled.push_back(out.style(lines.solids.back(), *colour));
        }
        return lines;
    }

private:
    // Another program may take a rule of few points: the volume under a span is that accurate by it.
    double accuracy() const {
        constexpr double part = 1e-9;
        const double size = cell_diagonal(joined_.cell), volume = joined_.cell.measures.volume;
        return part * (std::isnan(volume) ? size * size * size / 100 : volume);
    }

    // What no reader tells from a point, but for cells that are hardly larger themselves.
    double shortest(double least_uncertainty) const {
        constexpr double of_cell = 1e-6;
        return std::min(least_uncertainty, of_cell * cell_diagonal(joined_.cell));
    }

    std::vector<int> write_edges(Lines& out, const std::vector<int>& vertices,
                                 const std::vector<int>& surfaces) const {
        std::vector<std::vector<int>> in_parameters(solid_.edges.size());
        for (std::size_t f = 0; f < solid_.faces.size(); ++f)
            for (const auto& loop : solid_.faces[f].loops)
                for (const Solid::Use& use : loop) {
                    const int c = out.curve(use.curve);
                    const int context = out.add(
                        "(GEOMETRIC_REPRESENTATION_CONTEXT(2) PARAMETRIC_REPRESENTATION_CONTEXT() "
                        "REPRESENTATION_CONTEXT('2D SPACE',''))");
                    const int rep = out.add("DEFINITIONAL_REPRESENTATION('',(#{}),#{})", c, context);
                    in_parameters[use.edge].push_back(out.add("PCURVE('',#{},#{})", surfaces[f], rep));
                }
        std::vector<int> edges;
        for (std::size_t e = 0; e < solid_.edges.size(); ++e) {
            const auto& [ends, in_space] = solid_.edges[e];
            const int on_surfaces = out.add("SURFACE_CURVE('',#{},{},.CURVE_3D.)", out.curve(in_space),
                                            references(in_parameters[e]));
            edges.push_back(
                out.add("EDGE_CURVE('',#{},#{},#{},.T.)", vertices[ends[0]], vertices[ends[1]], on_surfaces));
        }
        return edges;
    }

    // Counter-clockwise seen from outside, where the surface's normal points.
    int write_face(Lines& out, std::uint32_t f, const std::vector<int>& edges, int surface) const {
        std::vector<int> bounds;
        for (const auto& loop : solid_.faces[f].loops) {
            std::vector<int> sides;
            for (const Solid::Use& use : loop)
                sides.push_back(
                    out.add("ORIENTED_EDGE('',*,*,#{},{})", edges[use.edge], flag(!use.reversed)));
            const int edge_loop = out.add("EDGE_LOOP('',{})", references(sides));
            bounds.push_back(
                out.add("{}('',#{},.T.)", bounds.empty() ? "FACE_OUTER_BOUND" : "FACE_BOUND", edge_loop));
        }
        return out.add("ADVANCED_FACE('{}',{},#{},.T.)",
                       to_string(site_in_diagram(joined_.cell, shell_.faces[solid_.faces[f].of].site)),
                       references(bounds), surface);
    }

    const JoinedParts joined_;
    const Shell shell_;
    const Solid solid_;
};

class File {
public:
    File(std::ostream& out, std::string_view name, std::string_view units)
        : out_(out), lines_(out), name_(name), unit_(unit_of(units)) {
        out << "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('Voronoi " << name << "'),'2;1');\nFILE_NAME('"
            << name
            << "','',(''),(''),'vcell','vcell','');\n"
               "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n";
    }

    void add(const Cell& cell, std::string_view name, std::optional<std::string_view> colour) {
        const CellSolid solid(cell, least_uncertainty_);
        const CellSolid::Written lines = solid.write(lines_, name, colour);
        solids_.insert(solids_.end(), lines.solids.begin(), lines.solids.end());
        styled_.insert(styled_.end(), lines.styled.begin(), lines.styled.end());
        off_ = std::max(off_, solid.off());
    }

    void finish() {
        add_product();
        out_ << "ENDSEC;\nEND-ISO-10303-21;\n";
    }

private:
    void add_product() {
        constexpr double room = 1.2;  // what readers round
        const int length = lines_.add("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({},.METRE.))", unit_.prefix);
        const int angle = lines_.add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))");
        const int solid_angle = lines_.add("(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT())");
        const int uncertainty =
            lines_.add("UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),#{},'distance_accuracy_value','')",
                       real(std::max(least_uncertainty_, room * off_)), length);
        const int context = lines_.add(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{})) "
            "GLOBAL_UNIT_ASSIGNED_CONTEXT((#{},#{},#{})) REPRESENTATION_CONTEXT('',''))",
            uncertainty, length, angle, solid_angle);
        const int world = lines_.add("AXIS2_PLACEMENT_3D('',#{},#{},#{})", lines_.point(Vec3::Zero().eval()),
                                     lines_.direction(Vec3::UnitZ()), lines_.direction(Vec3::UnitX()));
        std::vector<int> items{world};
        items.insert(items.end(), solids_.begin(), solids_.end());
        const int representation =
            lines_.add("ADVANCED_BREP_SHAPE_REPRESENTATION('{}',{},#{})", name_, references(items), context);
        lines_.add("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{},#{})", references(styled_),
                   context);
        const int application =
            lines_.add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
        lines_.add("APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2010,#{})",
                   application);
        const int product_context = lines_.add("PRODUCT_CONTEXT('',#{},'mechanical')", application);
        const int product = lines_.add("PRODUCT('{0}','{0}','',(#{1}))", name_, product_context);
        lines_.add("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{}))", product);
        const int formation = lines_.add("PRODUCT_DEFINITION_FORMATION('','',#{})", product);
        const int definition_context =
            lines_.add("PRODUCT_DEFINITION_CONTEXT('part definition',#{},'design')", application);
        const int definition =
            lines_.add("PRODUCT_DEFINITION('design','',#{},#{})", formation, definition_context);
        const int shape = lines_.add("PRODUCT_DEFINITION_SHAPE('','',#{})", definition);
        lines_.add("SHAPE_DEFINITION_REPRESENTATION(#{},#{})", shape, representation);
    }

    std::ostream& out_;
    Lines lines_;
    const std::string name_;
    const Unit unit_;
    const double least_uncertainty_ =
        1 / (1e7 * unit_.millimetres);  // OCCT's floor is 1e-7 mm, whatever the unit
    double off_ = 0;                    // the solid that is off most
    std::vector<int> solids_, styled_;
};

}  // namespace step

void write_step(std::ostream& out, const Cell& cell) {
    step::File file(out, "cell", cell.scene.units);
    file.add(cell, "cell", std::nullopt);
    file.finish();
}

DiagramStep::DiagramStep(std::ostream& out, const DiagramScene& scene)
    : file_(std::make_unique<step::File>(out, "diagram", scene.units)) {}
DiagramStep::~DiagramStep() = default;

void DiagramStep::add(std::uint32_t object, const Cell& cell) {
    file_->add(cell, cell_title(static_cast<std::int32_t>(object), cell),
               palette()[colours_.add(object, cell)]);
}

void DiagramStep::finish() { file_->finish(); }

}  // namespace vcell
