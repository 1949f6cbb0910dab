// IRIT files, read back: surfaces and curves are the cell's, loops close, and trims lie under their edges.
#include "../../io/files/itd_file.hpp"

#include <doctest/doctest.h>

#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "../../envelope/voronoi_cell.hpp"

namespace vcell {
namespace {

/// A bracket: its words before, between and after the brackets in it.
struct Node {
    std::vector<std::string> words;
    std::vector<Node> in;

    const Node& first(const std::string& kind) const {
        for (const Node& n : in)
            if (!n.words.empty() && n.words[0] == kind) return n;
        FAIL("no " << kind);
        return *this;
    }
};

Node parse(const std::string& text, std::size_t& at) {
    Node node;
    std::string word;
    const auto end_word = [&] {
        if (!word.empty()) node.words.push_back(word);
        word.clear();
    };
    for (; at < text.size(); ++at) {
        const char c = text[at];
        if (c == '[') {
            end_word();
            node.in.push_back(parse(text, ++at));
        } else if (c == ']') {
            break;
        } else if (c == ' ' || c == '\n') {
            end_word();
        } else {
            word += c;
        }
    }
    end_word();
    return node;
}

/// A Bezier or B-spline curve's or surface's control points, Euclidean.
template <int Dim>
std::vector<Eigen::Matrix<double, Dim + 1, 1>> points(const Node& node) {
    std::vector<Eigen::Matrix<double, Dim + 1, 1>> all;
    for (const Node& n : node.in) {
        if (n.words[0] == "KV") continue;
        REQUIRE(n.words.size() == Dim + 1);
        auto& p = all.emplace_back();
        p[Dim] = std::stod(n.words[0]);
        for (int k = 0; k < Dim; ++k) p[k] = std::stod(n.words[1 + k]) / p[Dim];
    }
    return all;
}

template <int Dim>
RationalCurve<Dim> curve_of(const Node& node) {
    REQUIRE(node.words[1] == "BSPLINE");
    RationalCurve<Dim> curve;
    curve.degree = std::stoi(node.words[3]) - 1;
    for (const auto& p : points<Dim>(node)) curve.points.push_back(p);
    CHECK(curve.points.size() == std::stoul(node.words[2]));
    const Node& knots = node.first("KV");
    for (std::size_t k = 1; k < knots.words.size(); ++k) curve.knots.push_back(std::stod(knots.words[k]));
    REQUIRE(curve.knots.size() == curve.points.size() + static_cast<std::size_t>(curve.degree) + 1);
    return curve;
}

}  // namespace

TEST_CASE("itd: a cell's patches, curves and vertices are read back, and trims lie under its edges") {
    Scene plane, sphere, tube;
    for (Scene* s : {&plane, &sphere, &tube}) {
        s->box = {Vec3(-2, -2, -2), Vec3(2, 2, 2)};
        s->objects = {Sphere{{0.5, 1, 1.25}, 0.25}, Sphere{{-1, -0.5, 1}, 0.5}, Sphere{{1, -1, 1.5}, 0}};
    }
    plane.base = Plane{{0, 0, 0}, {0, 0, 1}};
    sphere.base = Sphere{{0, 0, 0}, 0.25};
    tube.base = Cylinder{{0, 0, 0}, {0, 1, 0}, 0.125};
    for (const Scene* scene : {&plane, &sphere, &tube}) {
        const Cell cell = voronoi_cell(*scene);
        std::ostringstream out;
        write_itd(out, cell);
        std::size_t at = 0;
        const Node file = parse(out.str(), at);
        CHECK(at == out.str().size());
        std::map<std::string, const Node*> named;
        for (const Node& n : file.in) {
            REQUIRE(n.words[0] == "OBJECT");
            CHECK(named.emplace(n.words[1], &n).second);
        }
        std::size_t patches = 0;
        for (std::size_t f = 0; f < cell.faces.size(); ++f)
            for (std::size_t k = 0; k < cell.faces[f].patches.size(); ++k, ++patches) {
                const TrimmedPatch& patch = cell.faces[f].patches[k];
                const Node& object = *named.at("FACE" + std::to_string(f) + "_" + std::to_string(k));
                CHECK(object.first("neighbor").words[1] == "\"" + to_string(cell.faces[f].site) + "\"");
                const Node& trimmed = object.first("TRIMSRF");
                const Node& surface = trimmed.first("SURFACE");
                const int nu = std::stoi(surface.words[2]), nv = std::stoi(surface.words[3]);
                RationalPatch read{nu - 1, nv - 1, {0, 1}, {0, 1}, {}};
                const auto control = points<3>(surface);
                REQUIRE(control.size() == static_cast<std::size_t>(nu * nv));
                for (int i = 0; i < nu; ++i)
                    for (int j = 0; j < nv; ++j)
                        read.points.push_back(control[static_cast<std::size_t>(j * nu + i)]);
                std::size_t loops = 0;
                for (const Node& loop : trimmed.in) {
                    if (loop.words[0] != "TRIMCRV") continue;
                    const auto& trims = patch.loops.at(loops++);
                    REQUIRE(loop.in.size() == trims.size());
                    for (std::size_t s = 0; s < trims.size(); ++s) {
                        const RationalCurve2 c = curve_of<2>(loop.in[s].first("CURVE")),
                                             next =
                                                 curve_of<2>(loop.in[(s + 1) % trims.size()].first("CURVE"));
                        CHECK((c.evaluate(c.domain_end()) - next.evaluate(next.domain_begin())).norm() <
                              1e-9);
                        for (const double part : {0.0, 0.3, 0.5, 1.0}) {
                            const double t = std::lerp(c.domain_begin(), c.domain_end(), part);
                            const Vec2 uv = c.evaluate(t);
                            CHECK(uv.minCoeff() > -1e-9);
                            CHECK(uv.maxCoeff() < 1 + 1e-9);
                            if (!trims[s].edge) continue;
                            const CellEdge& edge = cell.edges[*trims[s].edge];
                            const RationalCurve3 space = curve_of<3>(
                                named.at("EDGE" + std::to_string(*trims[s].edge))->first("CURVE"));
                            const double in_space =
                                trims[s].reversed ? c.domain_begin() + c.domain_end() - t : t;
                            CHECK((read.evaluate(uv.x(), uv.y()) - space.evaluate(in_space)).norm() <=
                                  edge.error + 1e-12);
                        }
                    }
                }
                CHECK(loops == patch.loops.size());
            }
        CHECK(named.size() == patches + cell.edges.size() + cell.vertices.size());
        for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
            const Node& object = *named.at("VERTEX" + std::to_string(v));
            CHECK(std::stod(object.first("clearance").words[1]) == cell.vertices[v].radius);
            for (int k = 0; k < 3; ++k)
                CHECK(std::stod(object.first("POINT").words[1 + k]) == cell.vertices[v].point[k]);
        }
    }
}

}  // namespace vcell
