// Hunts scenes whose whole diagrams are wrong, incomplete, slow or too large, as hunt.cpp does for single
// cells: `hunt_diagrams --seed 7 --count 100 --save FOLDER`.
#include "../../io/files/stored_diagram.hpp"
#include "campaign.hpp"
#include "diagram_families.hpp"

using namespace vcell;
using namespace vcell::hunt;

int main(int argc, char** argv) {
    CLI::App app("Hunts hostile scenes on whose diagrams vcell fails.", "hunt_diagrams");
    Campaign campaign(app, {"rooms", "room", "box, pipe, slit, repeating, leaning"});
    CLI11_PARSE(app, argc, argv);
    return campaign.run(diagram_families(), rooms, write_diagram_scene);
}
