/// The atoms of a molecule among the tests' data.
#pragma once

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "../../primitives/objects/objects.hpp"
#include "../test_support.hpp"

namespace vcell {

inline std::vector<Sphere> molecule(const std::string& name) {
    std::ifstream file(test_data(name));
    std::vector<Sphere> balls;
    for (std::string line; std::getline(file, line);) {
        std::istringstream in(line);
        Sphere ball;
        if (in >> ball.center[0] >> ball.center[1] >> ball.center[2] >> ball.radius) balls.push_back(ball);
    }
    return balls;
}

}  // namespace vcell
