# Doxygen takes a header's first block for what the file is about if that says so.
1s|^///|/// \\file\
///|
