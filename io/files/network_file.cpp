#include "network_file.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

namespace vcell {

namespace {

std::string image_text(const std::array<std::int16_t, 3>& image) {
    return fmt::format("{},{},{}", image[0], image[1], image[2]);
}

std::string sites_text(const std::vector<NetworkSite>& sites) {
    std::string text;
    for (const NetworkSite& s : sites) {
        if (!text.empty()) text += ' ';
        text += to_string(s);
    }
    return text;
}

std::string number_or_dash(double x) { return std::isfinite(x) ? fmt::format("{}", x) : "-"; }

}  // namespace

void write_network(std::ostream& out, const VoidNetwork& network) {
    const auto sphere = [&](const char* name, const std::optional<NetworkSphere>& s) {
        if (s)
            fmt::print(out, "{}\t{}\t{}\n", name, s->diameter, s->error);
        else
            fmt::print(out, "{}\t-\t-\n", name);
    };
    out << "sphere\tdiameter\terror\n";
    sphere("Di", network.included);
    sphere("Df", network.free);
    sphere("Dif", network.included_along_free);
    sphere("Df_x", network.free_along[0]);
    sphere("Df_y", network.free_along[1]);
    sphere("Df_z", network.free_along[2]);
    out << "\nvertex\tx\ty\tz\tclearance\terror\ttouching\tsites\n";
    for (std::size_t i = 0; i < network.vertices.size(); ++i) {
        const NetworkVertex& v = network.vertices[i];
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{:d}\t{}\n", i, v.point.x(), v.point.y(), v.point.z(),
                   v.clearance, v.error, v.is_touching, sites_text(v.sites));
    }
    out << "\nedge\tfirst\tsecond\timage\tsites\tbottleneck\tbottleneck_error\tlength\tlength_error\n";
    for (std::size_t i = 0; i < network.edges.size(); ++i) {
        const NetworkEdge& e = network.edges[i];
        fmt::print(out, "{}", i);
        if (e.vertices)
            fmt::print(out, "\t{}\t{}", (*e.vertices)[0], (*e.vertices)[1]);
        else
            out << "\t-\t-";
        fmt::print(out, "\t{}\t{}\t{}\t{}\t{}\t{}\n", image_text(e.image), sites_text(e.sites), e.bottleneck,
                   e.bottleneck_error, number_or_dash(e.length), number_or_dash(e.length_error));
    }
    if (network.passages.empty()) return;
    out << "\npassage\tfirst\tsecond\timage\tsites\tbottleneck\tbottleneck_error\n";
    for (std::size_t i = 0; i < network.passages.size(); ++i) {
        const NetworkPassage& p = network.passages[i];
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{}\n", i, p.edges[0], p.edges[1], image_text(p.image),
                   sites_text(p.sites), p.bottleneck, p.bottleneck_error);
    }
}

void write_openpnm(std::ostream& out, const VoidNetwork& network) {
    out << "pore.coords[0],pore.coords[1],pore.coords[2],pore.diameter,pore.error,throat.conns[0],throat.conns[1],"
           "throat.image[0],throat.image[1],throat.image[2],throat.diameter,throat.error,throat.length\n";
    std::vector<const NetworkEdge*> throats;
    for (const NetworkEdge& e : network.edges)
        if (e.vertices) throats.push_back(&e);
    for (std::size_t i = 0; i < std::max(network.vertices.size(), throats.size()); ++i) {
        if (i < network.vertices.size()) {
            const NetworkVertex& v = network.vertices[i];
            fmt::print(out, "{},{},{},{},{},", v.point.x(), v.point.y(), v.point.z(), 2 * v.clearance,
                       2 * v.error);
        } else {
            out << ",,,,,";
        }
        if (i < throats.size()) {
            // OpenPNM sorts a throat's pores where it is given them anew, and not the image.
            const NetworkEdge& e = *throats[i];
            auto [first, second] = *e.vertices;
            std::array<std::int16_t, 3> image = e.image;
            if (second < first) {
                std::swap(first, second);
                for (std::int16_t& k : image) k = static_cast<std::int16_t>(-k);
            }
            fmt::print(out, "{},{},{},{},{},", first, second, image_text(image), 2 * e.bottleneck,
                       2 * e.bottleneck_error);
            if (std::isfinite(e.length)) fmt::print(out, "{}", e.length);
        } else {
            out << ",,,,,,,";
        }
        out << '\n';
    }
}

}  // namespace vcell
