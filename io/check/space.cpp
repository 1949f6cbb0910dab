#include "space.hpp"

namespace vcell::check {

template struct Surface<Interval>;
template struct Surface<Wide>;
template class Space<Interval>;
template class Space<Wide>;

}  // namespace vcell::check
