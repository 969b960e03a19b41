// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the fuzzing target on the lines of a packed corpus (corpus.py), without libFuzzer: for any
// compiler. Fails also where a result is not valid although there is a valid one.
#include "fuzz_report.h"

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

int main(int argument_count, char** arguments) {
    int input_count = 0;
    for (int i = 1; i < argument_count; ++i) {
        std::ifstream stream(arguments[i]);
        for (std::string line; std::getline(stream, line); ++input_count) {
            std::vector<std::uint8_t> bytes;
            for (std::size_t at = 0; at + 1 < line.size(); at += 2) {
                bytes.push_back(
                    static_cast<std::uint8_t>(std::stoi(line.substr(at, 2), nullptr, 16)));
            }
            // To know the input where the target ends the program.
            std::fprintf(stderr, "%s line %d\n", arguments[i], input_count + 1);
            LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
        }
    }
    const int missed = spheroseg::fuzz::counted(spheroseg::fuzz::Outcome::missed);
    std::printf("%d inputs replayed, %d possible results missed\n", input_count, missed);
    return input_count > 0 && missed == 0 ? 0 : 1;
}
