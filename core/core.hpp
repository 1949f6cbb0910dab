/// The ground floor: ids, errors, signs, intervals, exact numbers, spline forms.
#pragma once

#include "platform.hpp"

#include "curves/bspline.hpp"
#include "curves/circular_form.hpp"
#include "errors.hpp"
#include "ids.hpp"
#include "numbers/exact.hpp"
#include "numbers/interval.hpp"
#include "numbers/sign.hpp"
