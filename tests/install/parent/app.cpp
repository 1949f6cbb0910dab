#include <vcell/core/core.hpp>

int main() { return vcell::Interval(1.0).lower() == 1.0 ? 0 : 1; }
