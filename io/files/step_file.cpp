#include "step_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "../pictures/mesh.hpp"
#include "../pictures/site_style.hpp"
#include "../solids/joined_parts.hpp"
#include "../solids/solid.hpp"
#include "../solids/spline_surface.hpp"

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

// A prefix of the metre, and its millimetres.
struct Unit {
    std::string_view prefix;
    double millimetres;
};

// "m" has no prefix, and what is not known is taken for mm.
Unit unit_of(const Cell& cell) {
    constexpr Unit millimetre{".MILLI.", 1}, micrometre{".MICRO.", 1e-3};
    constexpr std::array<std::pair<std::string_view, Unit>, 5> known{{{"m", {"$", 1e3}},
                                                                      {"cm", {".CENTI.", 10}},
                                                                      {"um", micrometre},
                                                                      {"\u00b5m", micrometre},
                                                                      {"nm", {".NANO.", 1e-6}}}};
    const auto unit = std::ranges::find(known, cell.scene.units, [](const auto& k) { return k.first; });
    return unit == known.end() ? millimetre : unit->second;
}

class StepFile {
public:
    explicit StepFile(const Cell& cell) : joined_(joined_parts(cell)), cell_(joined_.cell) {}

    void write(std::ostream& out) {
        for (const Vec3& v : solid_.vertices) vertices_.push_back(add("VERTEX_POINT('',#{})", point(v)));
        for (const Solid::Face& f : solid_.faces)
            surfaces_.push_back(f.is_flat ? plane(f) : surface(f.surface));
        add_edges();
        std::vector<int> solids;
        for (const std::vector<std::uint32_t>& part : solid_.parts) {
            std::vector<int> faces;
            for (const std::uint32_t f : part) faces.push_back(face(f));
            const int shell = add("CLOSED_SHELL('',{})", references(faces));
            solids.push_back(add("MANIFOLD_SOLID_BREP('cell',#{})", shell));
        }
        add_product(solids);
        out << "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('Voronoi cell'),'2;1');\n"
               "FILE_NAME('cell','',(''),(''),'vcell','vcell','');\n"
               "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n";
        for (std::size_t i = 0; i < lines_.size(); ++i) out << '#' << i + 1 << '=' << lines_[i] << ";\n";
        out << "ENDSEC;\nEND-ISO-10303-21;\n";
    }

private:
    // Of the volume under a span, by the rule of few points that another program may take.
    double accuracy() const {
        constexpr double part = 1e-9;
        const double size = cell_diagonal(cell_);
        return part * (std::isnan(cell_.measures.volume) ? size * size * size / 100 : cell_.measures.volume);
    }

    // What no reader tells from a point, but for cells that are hardly larger themselves.
    double shortest() const {
        constexpr double of_cell = 1e-6;
        return std::min(least_uncertainty_, of_cell * cell_diagonal(cell_));
    }

    template <class... Args>
    int add(fmt::format_string<Args...> format, Args&&... args) {
        lines_.push_back(fmt::format(format, std::forward<Args>(args)...));
        return static_cast<int>(lines_.size());
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

    int surface(const RationalPatch& patch) {
        const SplineSurface s = with_knots(patch, accuracy_);
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

    void add_edges() {
        std::vector<std::vector<int>> in_parameters(solid_.edges.size());
        for (std::size_t f = 0; f < solid_.faces.size(); ++f)
            for (const auto& loop : solid_.faces[f].loops)
                for (const Solid::Use& use : loop) {
                    const int c = curve(use.curve);
                    const int context =
                        add("(GEOMETRIC_REPRESENTATION_CONTEXT(2) PARAMETRIC_REPRESENTATION_CONTEXT() "
                            "REPRESENTATION_CONTEXT('2D SPACE',''))");
                    const int rep = add("DEFINITIONAL_REPRESENTATION('',(#{}),#{})", c, context);
                    in_parameters[use.edge].push_back(add("PCURVE('',#{},#{})", surfaces_[f], rep));
                }
        for (std::size_t e = 0; e < solid_.edges.size(); ++e) {
            const auto& [ends, in_space] = solid_.edges[e];
            const int on_surfaces =
                add("SURFACE_CURVE('',#{},{},.CURVE_3D.)", curve(in_space), references(in_parameters[e]));
            edges_.push_back(
                add("EDGE_CURVE('',#{},#{},#{},.T.)", vertices_[ends[0]], vertices_[ends[1]], on_surfaces));
        }
    }

    // Counter-clockwise seen from outside, where the surface's normal points.
    int face(std::size_t f) {
        const CellFace& of = shell_.faces[solid_.faces[f].of];
        std::vector<int> bounds;
        for (const auto& loop : solid_.faces[f].loops) {
            std::vector<int> sides;
            for (const Solid::Use& use : loop)
                sides.push_back(add("ORIENTED_EDGE('',*,*,#{},{})", edges_[use.edge], flag(!use.reversed)));
            const int edge_loop = add("EDGE_LOOP('',{})", references(sides));
            bounds.push_back(
                add("{}('',#{},.T.)", bounds.empty() ? "FACE_OUTER_BOUND" : "FACE_BOUND", edge_loop));
        }
        const int face =
            add("ADVANCED_FACE('{}',{},#{},.T.)", to_string(of.site), references(bounds), surfaces_[f]);
        colour(face,
               of.site.is_object() ? palette()[colours_.at(of.site.index)] : std::string_view("#dddddd"));
        return face;
    }

    void colour(int face, std::string_view colour) {
        const std::array<int, 3> rgb = channels(colour);
        const int c =
            add("COLOUR_RGB('',{},{},{})", real(rgb[0] / 255.0), real(rgb[1] / 255.0), real(rgb[2] / 255.0));
        const int fill = add("FILL_AREA_STYLE('',(#{}))", add("FILL_AREA_STYLE_COLOUR('',#{})", c));
        const int side = add("SURFACE_SIDE_STYLE('',(#{}))", add("SURFACE_STYLE_FILL_AREA(#{})", fill));
        const int style =
            add("PRESENTATION_STYLE_ASSIGNMENT((#{}))", add("SURFACE_STYLE_USAGE(.BOTH.,#{})", side));
        styled_.push_back(add("STYLED_ITEM('',(#{}),#{})", style, face));
    }

    int direction(const Vec3& d) { return add("DIRECTION('',{})", reals(d)); }

    void add_product(const std::vector<int>& solids) {
        constexpr double room = 1.2;  // what readers round
        const int length = add("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({},.METRE.))", unit_.prefix);
        const int angle = add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))");
        const int solid_angle = add("(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT())");
        const int uncertainty =
            add("UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({}),#{},'distance_accuracy_value','')",
                real(std::max(least_uncertainty_, room * solid_.off)), length);
        const int context =
            add("(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{})) "
                "GLOBAL_UNIT_ASSIGNED_CONTEXT((#{},#{},#{})) REPRESENTATION_CONTEXT('',''))",
                uncertainty, length, angle, solid_angle);
        const int world = add("AXIS2_PLACEMENT_3D('',#{},#{},#{})", point(Vec3::Zero().eval()),
                              direction(Vec3::UnitZ()), direction(Vec3::UnitX()));
        std::vector<int> items{world};
        items.insert(items.end(), solids.begin(), solids.end());
        const int representation =
            add("ADVANCED_BREP_SHAPE_REPRESENTATION('cell',{},#{})", references(items), context);
        add("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{},#{})", references(styled_),
            context);
        const int application =
            add("APPLICATION_CONTEXT('core data for automotive mechanical design processes')");
        add("APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2010,#{})",
            application);
        const int product_context = add("PRODUCT_CONTEXT('',#{},'mechanical')", application);
        const int product = add("PRODUCT('cell','cell','',(#{}))", product_context);
        add("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{}))", product);
        const int formation = add("PRODUCT_DEFINITION_FORMATION('','',#{})", product);
        const int definition_context =
            add("PRODUCT_DEFINITION_CONTEXT('part definition',#{},'design')", application);
        const int definition = add("PRODUCT_DEFINITION('design','',#{},#{})", formation, definition_context);
        const int shape = add("PRODUCT_DEFINITION_SHAPE('','',#{})", definition);
        add("SHAPE_DEFINITION_REPRESENTATION(#{},#{})", shape, representation);
    }

    const JoinedParts joined_;
    const Cell& cell_;
    const Unit unit_ = unit_of(cell_);
    const double least_uncertainty_ =
        1 / (1e7 * unit_.millimetres);  // OCCT's floor is 1e-7 mm, whatever the unit
    const std::unordered_map<std::uint32_t, std::size_t> colours_ = object_colours(cell_);
    const Shell shell_ = closed_shell(cell_);
    const Solid solid_ = solid_of(shell_, cell_.faces.size(), shortest());
    const double accuracy_ = accuracy();
    std::vector<std::string> lines_;
    std::vector<int> vertices_, surfaces_, edges_, styled_;
};

}  // namespace

void write_step(std::ostream& out, const Cell& cell) { StepFile(cell).write(out); }

}  // namespace vcell
