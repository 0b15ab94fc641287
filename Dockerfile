# q2q on ROS 2 Jazzy: docker build -t q2q . && docker run --rm -it q2q
FROM ros:jazzy AS base
# The distribution's own versions: they are those of the base image.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install -y --no-install-recommends build-essential git python3-dev python3-venv \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /q2q

FROM base
COPY . .
RUN bash -c "source /opt/ros/jazzy/setup.bash && scripts/setup"
CMD ["scripts/demo"]
