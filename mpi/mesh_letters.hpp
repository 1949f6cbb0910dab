/// What a cell's mesh leaves for others (shared::Additions), from one process to another.
#pragma once

#include "../io/pictures/shared_elements.hpp"
#include "letter.hpp"

namespace vcell::mpi {

void put_additions(Letter& letter, const shared::Additions& additions);
shared::Additions get_additions(LetterReader& in);

}  // namespace vcell::mpi
