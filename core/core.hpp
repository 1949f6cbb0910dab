/// The ground floor: ids, errors, signs, intervals, exact numbers, spline forms.
#pragma once

#include "platform.hpp"

#include "bspline.hpp"
#include "circular_form.hpp"
#include "errors.hpp"
#include "exact.hpp"
#include "ids.hpp"
#include "interval.hpp"
#include "sign.hpp"
