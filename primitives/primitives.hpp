/// Objects, scenes and sites; bases in canonical position with the heights of everything above them.
#pragma once

#include "bisector.hpp"
#include "height_conics.hpp"
#include "objects.hpp"
#include "plane_base.hpp"
#include "scene.hpp"
#include "site.hpp"
#include "trisector.hpp"
