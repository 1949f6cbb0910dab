// Exit status 0 when the installed headers and archive work together.
#include <vcell/vcell.hpp>

int main() {
    const vcell::Exact third = vcell::Exact(1.0) + vcell::Exact(2.0);
    return third.enclosure().contains(3.0) ? 0 : 1;
}
