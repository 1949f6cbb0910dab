#include <vcell/core/numbers/interval.hpp>

int main() { return vcell::Interval(1.0).lower() == 1.0 ? 0 : 1; }
