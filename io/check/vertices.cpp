#include "vertices.hpp"

#include <fmt/format.h>

#include <cmath>

namespace vcell::check {
namespace {

class Vertices : public Room {
public:
    using Room::Room;

    void run() {
        check_vertices();
    }

private:
    void check_vertices() {
        for (std::size_t i = 0; i < cell_.vertices.size(); ++i) {
            const CellVertex& v = cell_.vertices[i];
            if (std::abs(height(v.point) - v.radius) > v.error + rounding())
                note(vertex_path(i) + ".radius",
                     fmt::format("is {}, the base is {} away", v.radius, height(v.point)));
            std::vector<Site> attained;
            for (const Site& s : v.sites)
                if (geometry_.distance_from_rim(s, v.point) > v.error + rounding()) attained.push_back(s);
            if (const auto what = contradiction(v.point, v.error, attained)) note(vertex_path(i), *what);
        }
    }
};

}  // namespace

void certify_vertices(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Vertices(subject, options, certificate).run();
}

}  // namespace vcell::check
