// Hunts scenes whose cells are wrong, refused, slow or too large: `hunt --seed 7 --count 1000 --save FOLDER`.
// Each scene's own seed is printed with its outcome, and gives the same scene again (`--seed K --count 1`).
#include "../../io/files/scene_file.hpp"
#include "campaign.hpp"
#include "families.hpp"

using namespace vcell;
using namespace vcell::hunt;

int main(int argc, char** argv) {
    CLI::App app("Hunts hostile scenes on which vcell fails.", "hunt");
    Campaign campaign(app, {"bases", "base", "plane, tilted-plane, ball, tube, tilted-tube"});
    CLI11_PARSE(app, argc, argv);
    return campaign.run(families(), base_kinds, write_scene);
}
