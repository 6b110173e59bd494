/// Makes the shipped sequence anew: render_sequence FOLDER
#include <exception>
#include <iostream>

#include "sequence.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: render_sequence FOLDER   (writes conveyor.y4m, training.png and truth.csv there)\n";
    return 2;
  }
  try {
    vsfind::render::write_sequence(argv[1]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 3;
  }
  return 0;
}
