#include "host/view/gl.hpp"

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::view::gl {
namespace {

GLuint compile(GLenum kind, const char* source) {
    const GLuint id = glCreateShader(kind);
    glShaderSource(id, 1, &source, nullptr);
    glCompileShader(id);
    GLint is_good = 0;
    glGetShaderiv(id, GL_COMPILE_STATUS, &is_good);
    if (is_good == GL_TRUE) return id;
    std::array<char, 2048> log{};
    glGetShaderInfoLog(id, static_cast<GLsizei>(log.size()), nullptr, log.data());
    glDeleteShader(id);
    throw std::runtime_error(std::string("shader: ") + log.data());
}

}  // namespace

Program::Program(const char* vertex_source, const char* fragment_source) {
    const GLuint vertex = compile(GL_VERTEX_SHADER, vertex_source);
    const GLuint fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
    id_ = glCreateProgram();
    glAttachShader(id_, vertex);
    glAttachShader(id_, fragment);
    glLinkProgram(id_);
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    GLint is_good = 0;
    glGetProgramiv(id_, GL_LINK_STATUS, &is_good);
    if (is_good == GL_TRUE) return;
    std::array<char, 2048> log{};
    glGetProgramInfoLog(id_, static_cast<GLsizei>(log.size()), nullptr, log.data());
    glDeleteProgram(id_);
    throw std::runtime_error(std::string("shader program: ") + log.data());
}

Program::~Program() {
    glDeleteProgram(id_);
}

void Program::set(const char* name, const Eigen::Matrix4f& value) const {
    glUniformMatrix4fv(at(name), 1, GL_FALSE, value.data());
}
void Program::set(const char* name, const Eigen::Vector3f& value) const {
    glUniform3fv(at(name), 1, value.data());
}
void Program::set(const char* name, const Eigen::Vector4f& value) const {
    glUniform4fv(at(name), 1, value.data());
}
void Program::set(const char* name, float value) const {
    glUniform1f(at(name), value);
}
void Program::set(const char* name, int value) const {
    glUniform1i(at(name), value);
}

Vertices::Vertices() {
    glGenVertexArrays(1, &array_);
    glGenBuffers(1, &buffer_);
    glGenBuffers(1, &indices_);
    bind();
}

Vertices::~Vertices() {
    glDeleteBuffers(1, &buffer_);
    glDeleteBuffers(1, &indices_);
    glDeleteVertexArrays(1, &array_);
}

void Vertices::bind() const {
    glBindVertexArray(array_);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
}

void Vertices::upload(const void* data, std::size_t n_bytes) const {
    bind();
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(n_bytes), data, GL_DYNAMIC_DRAW);
}

void Vertices::upload_indices(std::span<const std::uint32_t> indices) const {
    bind();
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size_bytes()), indices.data(),
                 GL_DYNAMIC_DRAW);
}

void Vertices::attribute(GLuint index, int n_floats, int stride_floats, int offset_floats) const {
    bind();
    const auto bytes = static_cast<GLsizei>(sizeof(float));
    const auto offset = static_cast<std::uintptr_t>(offset_floats) * sizeof(float);
    glEnableVertexAttribArray(index);
    // OpenGL takes the offset into the buffer as a pointer.
    glVertexAttribPointer(index, n_floats, GL_FLOAT, GL_FALSE, stride_floats * bytes,
                          reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
}

Texture::Texture(Size size, GLint internal_format, GLenum format, GLenum type, const void* data) {
    glGenTextures(1, &id_);
    glBindTexture(GL_TEXTURE_2D, id_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, internal_format, size.width, size.height, 0, format, type, data);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

Texture::~Texture() {
    glDeleteTextures(1, &id_);
}

void Texture::bind(GLuint unit) const {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_2D, id_);
    glActiveTexture(GL_TEXTURE0);
}

Target::Target(std::initializer_list<const Texture*> colours, const Texture* depth) {
    glGenFramebuffers(1, &id_);
    glBindFramebuffer(GL_FRAMEBUFFER, id_);
    std::vector<GLenum> drawn;
    for (const Texture* colour : colours) {
        const GLenum slot = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(drawn.size());
        glFramebufferTexture2D(GL_FRAMEBUFFER, slot, GL_TEXTURE_2D, colour->id(), 0);
        drawn.push_back(slot);
    }
    if (depth != nullptr) {
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth->id(), 0);
    }
    glDrawBuffers(static_cast<GLsizei>(drawn.size()), drawn.data());
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return;
    glDeleteFramebuffers(1, &id_);
    throw std::runtime_error("OpenGL refuses the framebuffer (too large a picture?)");
}

Target::~Target() {
    glDeleteFramebuffers(1, &id_);
}

}  // namespace palpate::view::gl
