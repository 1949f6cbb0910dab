#include "krawczyk.hpp"

namespace vcell {

template Step<Interval, 2> krawczyk_step<Interval, 2>(const LocalModel<Interval, 2>&,
                                                      const Offsets<Interval, 2>&, const IntervalBox<2>&,
                                                      Preconditioning);
template Step<Wide, 2> krawczyk_step<Wide, 2>(const LocalModel<Wide, 2>&, const Offsets<Wide, 2>&,
                                              const WideBox<2>&, Preconditioning);

}  // namespace vcell
