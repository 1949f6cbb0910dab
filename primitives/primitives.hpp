/// Objects, scenes and sites; bases in canonical position with the heights of everything above them.
#pragma once

#include "bases/plane_base.hpp"
#include "bisectors/bisector.hpp"
#include "bisectors/height_conics.hpp"
#include "bisectors/trisector.hpp"
#include "bisectors/vertex_roots.hpp"
#include "objects/objects.hpp"
#include "objects/scene.hpp"
#include "objects/site.hpp"
