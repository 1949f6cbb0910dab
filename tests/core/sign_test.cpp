#include <doctest/doctest.h>

#include <string>

#include "../../core/errors.hpp"
#include "../../core/numbers/sign.hpp"

namespace vcell::sign_test {

TEST_CASE("Sign: multiplies and negates as signs do") {
    for (const int a : {-2, 0, 3}) {
        CHECK(-sign_of(a) == sign_of(-a));
        for (const int b : {-5, 0, 7}) CHECK(sign_of(a) * sign_of(b) == sign_of(a * b));
    }
    CHECK(sign_of(-0.0) == Sign::Zero);
}

TEST_CASE("Decisions: every rung counts towards the total") {
    Decisions d{1, 20, 300, 4000, 50000};
    CHECK(d.total() == 54321);
    d += d;
    CHECK(d == Decisions{2, 40, 600, 8000, 100000});
}

TEST_CASE("InputError: the message names the path first") {
    const InputError e(InputError::Kind::NegativeRadius, 3, "objects[3].sphere.radius",
                       "must be >= 0, is -1");
    CHECK(std::string(e.what()) == "objects[3].sphere.radius: must be >= 0, is -1");
    CHECK(e.path == "objects[3].sphere.radius");
    CHECK(e.object == 3);
    CHECK(e.kind == InputError::Kind::NegativeRadius);
    const InputError whole(InputError::Kind::Syntax, InputError::no_object, "", "not JSON");
    CHECK(std::string(whole.what()) == "not JSON");
}

}  // namespace vcell::sign_test
