# The program in an image without anything else: docker build -t spinebench . && docker run -v "$PWD:/work" spinebench --help
FROM rust:1-bookworm AS build
WORKDIR /source
COPY . .
RUN make dist && mkdir /image && tar -xzf dist/*.tar.gz --strip-components 1 -C /image

FROM scratch
COPY --from=build /image /spinebench
WORKDIR /work
ENTRYPOINT ["/spinebench/spinebench"]
