// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "raw_mesh.h"

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace spheroseg {

/// Reads triangle meshes without any library: .obj, .ply (ascii or binary little endian, vertices x
/// y z first or anywhere, faces as lists of three) and .raw (scripts/reproduce.py). Throws
/// InvalidInput with the reason.
class MeshFile {
public:
    static TriangleMesh read(const std::string& path) {
        const std::string extension = path.substr(path.find_last_of('.') + 1);
        if (extension == "obj") {
            return MeshFile(path).read_obj();
        }
        if (extension == "ply") {
            return MeshFile(path).read_ply();
        }
        if (extension == "raw") {
            return read_raw_mesh(path);
        }
        throw InvalidInput("Expected a .obj, .ply or .raw file, found " + path + ".");
    }

private:
    struct Property {
        std::string name;
        std::string type;
        std::string count_type; // of a list; empty otherwise
    };
    struct Element {
        std::string name;
        int count = 0;
        std::vector<Property> properties;
    };

    explicit MeshFile(const std::string& path) : path_(path), file_(path, std::ios::binary) {
        require(static_cast<bool>(file_), "a readable file");
    }

    void require(bool condition, const std::string& expected) const {
        if (!condition) {
            throw InvalidInput("Expected " + expected + " in " + path_ + ", found none.");
        }
    }

    TriangleMesh read_obj() {
        TriangleMesh mesh;
        for (std::string line; std::getline(file_, line);) {
            std::istringstream words(line);
            std::string kind;
            words >> kind;
            if (kind == "v") {
                Vec3 p;
                require(static_cast<bool>(words >> p.x >> p.y >> p.z), "three coordinates per v");
                mesh.positions.push_back(p);
            } else if (kind == "f") {
                std::vector<int> corners;
                for (std::string corner; words >> corner;) {
                    const int index = std::atoi(corner.c_str()); // up to the first slash
                    corners.push_back(index < 0 ? mesh.vertex_count() + index : index - 1);
                }
                require(corners.size() == 3, "triangles only");
                mesh.faces.push_back({corners[0], corners[1], corners[2]});
            }
        }
        require(!mesh.faces.empty(), "a face");
        return mesh;
    }

    TriangleMesh read_ply() {
        const std::vector<Element> elements = read_ply_header();
        TriangleMesh mesh;
        for (const Element& element : elements) {
            for (int i = 0; i < element.count; ++i) {
                Vec3 p;
                for (const Property& property : element.properties) {
                    read_ply_property(element, property, p, mesh);
                }
                if (element.name == "vertex") {
                    mesh.positions.push_back(p);
                }
            }
        }
        require(!mesh.faces.empty(), "a face");
        return mesh;
    }

    std::vector<Element> read_ply_header() {
        std::vector<Element> elements;
        std::string line;
        require(std::getline(file_, line) && line.compare(0, 3, "ply") == 0, "a PLY header");
        while (std::getline(file_, line)) {
            std::istringstream words(line);
            std::string kind;
            words >> kind;
            if (kind == "end_header") {
                return elements;
            }
            if (kind == "format") {
                std::string format;
                words >> format;
                require(format != "binary_big_endian", "an ascii or little-endian format");
                is_ascii_ = format == "ascii";
            } else if (kind == "element") {
                Element element;
                words >> element.name >> element.count;
                elements.push_back(element);
            } else if (kind == "property") {
                require(!elements.empty(), "an element before its properties");
                Property property;
                words >> property.type;
                if (property.type == "list") {
                    words >> property.count_type >> property.type;
                }
                words >> property.name;
                elements.back().properties.push_back(property);
            }
        }
        require(false, "end_header");
        return elements;
    }

    void read_ply_property(const Element& element,
                           const Property& property,
                           Vec3& p,
                           TriangleMesh& mesh) {
        if (property.count_type.empty()) {
            const double value = read_value(property.type);
            if (property.name == "x") {
                p.x = value;
            } else if (property.name == "y") {
                p.y = value;
            } else if (property.name == "z") {
                p.z = value;
            }
            return;
        }
        std::vector<int> values(static_cast<std::size_t>(read_value(property.count_type)));
        for (int& value : values) {
            value = static_cast<int>(read_value(property.type));
        }
        if (element.name == "face" && property.name.compare(0, 5, "verte") == 0) {
            require(values.size() == 3, "triangles only");
            mesh.faces.push_back({values[0], values[1], values[2]});
        }
    }

    template <typename T> double read_binary() {
        T value{};
        file_.read(reinterpret_cast<char*>(&value), sizeof value);
        return static_cast<double>(value);
    }

    double read_value(const std::string& type) {
        double value = 0.0;
        if (is_ascii_) {
            file_ >> value;
        } else if (type == "float" || type == "float32") {
            value = read_binary<float>();
        } else if (type == "double" || type == "float64") {
            value = read_binary<double>();
        } else if (type == "uchar" || type == "uint8") {
            value = read_binary<std::uint8_t>();
        } else if (type == "char" || type == "int8") {
            value = read_binary<std::int8_t>();
        } else if (type == "ushort" || type == "uint16") {
            value = read_binary<std::uint16_t>();
        } else if (type == "short" || type == "int16") {
            value = read_binary<std::int16_t>();
        } else if (type == "uint" || type == "uint32") {
            value = read_binary<std::uint32_t>();
        } else {
            value = read_binary<std::int32_t>();
        }
        require(static_cast<bool>(file_), "as many numbers as the header says");
        return value;
    }

    std::string path_;
    std::ifstream file_;
    bool is_ascii_ = true;
};

} // namespace spheroseg
